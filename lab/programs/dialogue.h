// Another program that answers each line with a line, over its standard input and output. It is this process's child,
// and ended with the object. Reads the clock, to find out that an answer does not come. One owner.
#pragma once

#include <sys/types.h>

#include <string>

#include "base/result.h"
#include "base/time.h"

namespace foreland::lab {

class Dialogue {
 public:
  static constexpr Duration kPatience = Duration::seconds(30);
  static constexpr size_t kMaxAnswerBytes = 1 << 20;

  // Starts the command: a program, which is looked for in PATH if its name has no slash, and its arguments, with spaces
  // between them; nothing is quoted. Its stderr is ours. kNotFound or kIo if it cannot be started.
  static Result<Dialogue> start(const std::string& command, Duration patience = kPatience);
  Dialogue(Dialogue&& other) noexcept;
  Dialogue& operator=(Dialogue&&) = delete;
  // Tells the program by the end of its input that nobody asks any more, gives it a moment, and ends it.
  ~Dialogue();

  // Sends the line and takes the next line that the program prints, both without their ends. An Error that says what
  // went wrong, but does not name the command, if the program has ended, does not read or does not answer in
  // `patience`, or answers without end. To be asked no more after that. Blocks.
  Result<std::string> ask(const std::string& line);

 private:
  Dialogue(pid_t pid, int input, int output, Duration patience)
      : pid_(pid), input_(input), output_(output), patience_(patience) {}
  Status send(const std::string& text, int64_t until_us) const;
  Error ended();

  pid_t pid_;  // 0: it has ended
  int input_, output_;
  Duration patience_;
  std::string read_;  // of the answers after the last one
};

}  // namespace foreland::lab
