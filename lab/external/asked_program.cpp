#include "lab/external/asked_program.h"

#include <cmath>

namespace foreland::lab {

namespace {

std::string nameOf(const ProgramRole& role, const std::string& command) { return role.option + " '" + command + "'"; }

std::string shortened(const std::string& text) {
  constexpr size_t kShown = 120;
  return text.size() <= kShown ? text : text.substr(0, kShown) + "...";
}

}  // namespace

Result<std::unique_ptr<AskedProgram>> AskedProgram::start(const ProgramRole& role, const std::string& command,
                                                          uint64_t seed, Duration patience) {
  auto dialogue = Dialogue::start(command, patience);
  if (!dialogue)
    return Error{dialogue.error().code,
                 nameOf(role, command) + ": " + dialogue.error().message +
                     "; give a program that can be run, and its arguments, such as 'python3 mine.py'"};
  std::unique_ptr<AskedProgram> program(new AskedProgram(role, command, std::move(*dialogue)));
  auto greeting = program->ask({{"foreland", kInstrumentVersion}, {"asked", role.asked}, {"seed", seed}});
  if (!greeting) return greeting.error();
  if (greeting->value("foreland", Json()) != kInstrumentVersion)
    return program->refuse("the first answer must say {\"foreland\": " + std::to_string(kInstrumentVersion) +
                           "}, the version that is spoken here");
  program->greeting_ = std::move(*greeting);
  return program;
}

Result<AskedProgram::Json> AskedProgram::ask(const Json& question) {
  if (!status_.ok()) return status_.error();
  ++line_;
  answer_.clear();
  auto answer = dialogue_.ask(question.dump());
  if (!answer) return fail(answer.error().message);
  answer_ = std::move(*answer);
  auto json = Json::parse(answer_, nullptr, false);
  if (!json.is_object()) return refuse("this is no JSON object");
  return json;
}

Error AskedProgram::refuse(const std::string& why) { return fail("'" + shortened(answer_) + "': " + why); }

Error AskedProgram::fail(const std::string& why) {
  if (status_.ok())
    status_ = Error{ErrorCode::kMalformed, nameOf(role_, command_) + ", answer " + std::to_string(line_) + ": " + why +
                                               "; docs/INSTRUMENT.md says how the program is to answer"};
  return status_.error();
}

Result<std::vector<double>> AskedProgram::numbers(const Json& answer, const char* name, size_t count) {
  const Json values = answer.value(name, Json());
  std::vector<double> numbers;
  for (const Json& value : values)
    if (value.is_number() && std::isfinite(value.get<double>())) numbers.push_back(value.get<double>());
  if (values.is_array() && values.size() == count && numbers.size() == count) return numbers;
  return refuse("\"" + std::string(name) + "\" must be a list of " + std::to_string(count) + " numbers");
}

Result<int64_t> AskedProgram::whole(const Json& answer, const char* name, int64_t least, int64_t most) {
  const Json value = answer.value(name, Json());
  const bool fits = value.is_number_unsigned() ? value.get<uint64_t>() <= static_cast<uint64_t>(INT64_MAX)
                                               : value.is_number_integer();
  if (fits && value.get<int64_t>() >= least && value.get<int64_t>() <= most) return value.get<int64_t>();
  return refuse("\"" + std::string(name) + "\" must be a whole number from " + std::to_string(least) + " to " +
                std::to_string(most));
}

}  // namespace foreland::lab
