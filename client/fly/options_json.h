// What a player was told to fly, as JSON: the beginning of a recording, for people and other programs to read. Pure;
// any thread.
#pragma once

#include <string>

#include "base/result.h"
#include "client/fly/player.h"

namespace foreland::client {

std::string optionsToJson(const PlayerOptions& options);
std::string choiceToJson(const ViewChoice& choice);
// Any text ends in options that a player can be made with, or in an Error that names the member that is wrong.
Result<PlayerOptions> optionsFromJson(const std::string& text);
Result<ViewChoice> choiceFromJson(const std::string& text);

}  // namespace foreland::client
