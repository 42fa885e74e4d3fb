#include "lab/report/draw_report.h"

#include <system_error>

#include "lab/programs/run_program.h"

namespace foreland::lab {

std::filesystem::path reportSources() { return FORELAND_SOURCE_DIR "/lab/report"; }

Result<std::string> drawReport(const std::filesystem::path& folder, const std::filesystem::path& sources) {
  std::error_code error;
  const std::filesystem::path results = folder / "results.json";
  if (!std::filesystem::is_regular_file(results, error))
    return Error{ErrorCode::kNotFound,
                 "there is no '" + results.string() + "'; run an experiment with --out " + folder.string() + " first"};
  const std::string install = "npm ci --prefix " + sources.string();
  if (!std::filesystem::exists(sources / "node_modules" / "@observablehq" / "plot", error))
    return Error{ErrorCode::kNotFound, "Observable Plot is not installed; run: " + install};
  auto said = runProgram({"node", (sources / "draw.mjs").string(), folder.string()});
  if (said) return said;
  if (said.error().code == ErrorCode::kNotFound)
    return Error{ErrorCode::kNotFound, "node is not installed; install nodejs, then run: " + install};
  return Error{ErrorCode::kMalformed, "cannot draw '" + folder.string() + "': its tables are not whole"};
}

}  // namespace foreland::lab
