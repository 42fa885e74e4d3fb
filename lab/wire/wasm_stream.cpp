#include "lab/wire/wasm_stream.h"

#include <nlohmann/json.hpp>

#include "lab/programs/lab_folder.h"
#include "lab/programs/run_program.h"
#include "lab/programs/temporary_folder.h"
#include "lab/programs/write_file.h"

namespace foreland::lab {

namespace {

namespace fs = std::filesystem;

void putMessage(ByteSpan message, ByteWriter& w) {
  w.put(static_cast<uint32_t>(message.size()));
  w.putBytes(message);
}

Status writeStream(const proto::Welcome& welcome, const std::vector<RecordedKeyframe>& flight, const fs::path& path) {
  Bytes stream;
  ByteWriter w(stream);
  putMessage(proto::encode(welcome), w);
  for (const RecordedKeyframe& k : flight) putMessage(k.message, w);
  return writeFile(stream, path);
}

}  // namespace

Result<nlohmann::json> runInWasm(const std::string& script, const fs::path& module, const proto::Welcome& welcome,
                                 const std::vector<RecordedKeyframe>& flight) {
  std::error_code ignored;
  if (!fs::exists(module, ignored))
    return Error{ErrorCode::kNotFound,
                 module.string() + " is not built; run: cmake --preset wasm && cmake --build --preset wasm"};
  const TemporaryFolder scratch;
  if (scratch.path().empty())
    return Error{ErrorCode::kIo, "no temporary folder can be made; set TMPDIR to where one can"};
  const fs::path stream = scratch.path() / "flight.stream";
  if (Status s = writeStream(welcome, flight, stream); !s.ok()) return s.error();
  const fs::path path = labFolder() / script;
  const auto printed = runProgram({"node", path.string(), module.string(), stream.string()});
  if (!printed && printed.error().code == ErrorCode::kNotFound)
    return Error{ErrorCode::kNotFound, "node is not installed; install nodejs"};
  if (!printed) return Error{ErrorCode::kMalformed, script + " failed: " + printed.error().message};
  auto report = nlohmann::json::parse(*printed, nullptr, false);
  if (report.is_discarded()) return Error{ErrorCode::kMalformed, script + " printed no JSON"};
  return report;
}

}  // namespace foreland::lab
