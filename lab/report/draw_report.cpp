#include "lab/report/draw_report.h"

#include <system_error>

#include "lab/programs/lab_folder.h"
#include "lab/programs/run_program.h"

namespace foreland::lab {

std::filesystem::path reportSources() { return labFolder() / "report"; }

Result<std::string> drawReport(const std::filesystem::path& folder, const std::filesystem::path& sources) {
  std::error_code error;
  const std::filesystem::path results = folder / "results.json";
  if (!std::filesystem::is_regular_file(results, error))
    return Error{ErrorCode::kNotFound,
                 "there is no '" + results.string() + "'; run an experiment with --out " + folder.string() + " first"};
  // As it is installed, draw.mjs holds its packages, and no package.json beside it names any.
  const bool needs_packages =
      !std::filesystem::exists(sources / "draw.mjs", error) || std::filesystem::exists(sources / "package.json", error);
  const std::string install = "npm ci --prefix " + sources.string();
  if (needs_packages && !std::filesystem::exists(sources / "node_modules" / "@observablehq" / "plot", error))
    return Error{ErrorCode::kNotFound, "Observable Plot is not installed; run: " + install};
  auto said = runProgram({"node", (sources / "draw.mjs").string(), folder.string()});
  if (said) return said;
  if (said.error().code == ErrorCode::kNotFound)
    return Error{ErrorCode::kNotFound,
                 "node is not installed; install nodejs" + (needs_packages ? ", then run: " + install : std::string())};
  return Error{ErrorCode::kMalformed, "cannot draw '" + folder.string() + "': its tables are not whole"};
}

}  // namespace foreland::lab
