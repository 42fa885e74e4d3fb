// A program of the user's that takes part in a run in virtual time: JSON lines on its standard input and output, one
// answer for each question, as docs/INSTRUMENT.md says. Virtual time stands still meanwhile, so what the program
// takes counts nowhere; a program that answers equally what is asked equally keeps a run's bytes.
//
// A run cannot stop amid an event. So the first failure stays: whoever asks afterwards gets the same Error at once,
// without the program, goes on with any answer, and the run's result is dropped for `status()`. One owner, a run's.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "lab/programs/dialogue.h"

namespace foreland::lab {

inline constexpr int kInstrumentVersion = 1;

// What a program is: the option that names it, such as --link-command, and what stands after it.
struct ProgramRole {
  std::string option, asked;  // `asked`: balance, order, predictor, link
};

class AskedProgram {
 public:
  using Json = nlohmann::ordered_json;

  // Starts the program and tells it version, role and the run's seed; takes its greeting. Errors name option and
  // command.
  static Result<std::unique_ptr<AskedProgram>> start(const ProgramRole& role, const std::string& command, uint64_t seed,
                                                     Duration patience = Dialogue::kPatience);

  // The first answer, an object with `foreland`.
  const Json& greeting() const { return greeting_; }
  // The program's answer, an object.
  Result<Json> ask(const Json& question);
  // Fails for the answer at hand, which is `why`, such as "server 9 takes no viewers".
  Error refuse(const std::string& why);
  // The first failure.
  const Status& status() const { return status_; }

  // The answer's numbers by this name, as many as `count`, finite; otherwise fails.
  Result<std::vector<double>> numbers(const Json& answer, const char* name, size_t count);
  // A whole number from `least` to `most`.
  Result<int64_t> whole(const Json& answer, const char* name, int64_t least, int64_t most);

 private:
  AskedProgram(ProgramRole role, std::string command, Dialogue dialogue)
      : role_(std::move(role)), command_(std::move(command)), dialogue_(std::move(dialogue)) {}
  Error fail(const std::string& why);

  ProgramRole role_;
  std::string command_;
  Dialogue dialogue_;
  Json greeting_;
  std::string answer_;
  uint64_t line_ = 0;
  Status status_;
};

}  // namespace foreland::lab
