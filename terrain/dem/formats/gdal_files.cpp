#include "terrain/dem/formats/gdal_files.h"

#include <cpl_conv.h>
#include <cpl_minixml.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <cpl_vsi_virtual.h>
#include <fmt/format.h>
#include <gdal.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

#include "terrain/dem/formats/gdal_messages.h"

namespace foreland::terrain {

namespace {

// Rasters in files. None of them opens connections; what is not here is no elevation or picture of anybody's.
constexpr std::string_view kDrivers =
    " AAIGrid ACE2 ADRG AIG BAG BIGGIF BMP BT BYN CEOS COASP COG CTG DIMAP DOQ1 DOQ2 DTED ECRGTOC"
    " EHdr EIR ELAS ENVI ERS ESAT ESRIC FAST FIT FITS FujiBAS GenBin GFF GIF GPKG GRASSASCIIGrid GRIB"
    " GS7BG GSAG GSBG GSC GTiff GTX GXF HDF4 HDF4Image HDF5 HDF5Image HF2 HFA IDA ILWIS ISCE ISG"
    " ISIS2 ISIS3 JP2OpenJPEG JPEG KRO L1B LAN LCP Leveller MAP MEM MFF MFF2 NDF netCDF NGSGEOID NITF"
    " NOAA_B NTv2 NWT_GRC NWT_GRD PAux PCIDSK PCRaster PDS PDS4 PNG PNM PRF R RIK RMF ROI_PAC RRASTER"
    " RST SAGA SDTS SGI SNODAS SRP SRTMHGT Terragen TGA TIL USGSDEM VICAR VRT WEBP XPM XYZ Zarr ZMap"
    " GMT ";
constexpr std::string_view kFileSystems[] = {"/vsizip/", "/vsigzip/", "/vsitar/", "/vsimem/", "/vsisubfile/"};

// What may be read and written, and what was refused. Leaked, since GDAL's file systems outlive all objects.
struct State {
  std::mutex mutex;
  size_t fences = 0;
  std::multiset<std::filesystem::path> folders, files;  // of all fences, resolved
  std::multiset<std::filesystem::path> outputs;
  std::optional<std::filesystem::path> refused;
};
State& state() {
  static State* const one = new State;
  return *one;
}

// Where GDAL and PROJ keep their own data.
const FileFence& systemData() {
  static const FileFence* const fence = [] {
    std::vector<std::filesystem::path> folders{"/usr/share/gdal", "/usr/share/proj", "/usr/local/share/gdal",
                                               "/usr/local/share/proj"};
    for (const char* name : {"GDAL_DATA", "PROJ_LIB", "PROJ_DATA"})
      if (const char* path = std::getenv(name)) folders.emplace_back(path);
    return new FileFence({}, folders);
  }();
  return *fence;
}

// Whether some fence holds a file: as many look-ups as it has folders above it, however many fences there are.
bool isHeld(const State& s, const std::filesystem::path& file) {
  if (s.files.contains(file)) return true;
  for (std::filesystem::path folder = file;; folder = folder.parent_path()) {
    if (s.folders.contains(folder)) return true;
    if (folder == folder.parent_path()) return false;
  }
}

bool mayRead(const char* path) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  if (s.fences == 0 || s.outputs.contains(path)) return true;
  const std::filesystem::path file = FileFence::resolved(path);
  if (file.empty()) return false;
  if (isHeld(s, file) || systemData().mayRead(file)) return true;
  std::error_code failed;
  if (!s.refused && std::filesystem::exists(file, failed)) s.refused = file;
  return false;
}

bool mayWrite(const char* path) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  return s.fences == 0 || s.outputs.contains(path);
}

bool isRead(const char* access) {
  return access[0] == 'r' && std::string_view(access).find('+') == std::string_view::npos;
}

// The file system of this machine, for those that may.
class FencedFiles final : public VSIFilesystemHandler {
 public:
  explicit FencedFiles(VSIFilesystemHandler* inner) : inner_(inner) {}

  VSIVirtualHandle* Open(const char* path, const char* access, bool sets_error, CSLConstList options) override {
    if (isRead(access) ? mayRead(path) : mayWrite(path)) return inner_->Open(path, access, sets_error, options);
    errno = EACCES;
    return nullptr;
  }
  int Stat(const char* path, VSIStatBufL* out, int flags) override {
    if (mayRead(path)) return inner_->Stat(path, out, flags);
    errno = EACCES;
    return -1;
  }
  char** ReadDirEx(const char* path, int most) override {
    return mayRead(path) ? inner_->ReadDirEx(path, most) : nullptr;
  }
  char** ReadDir(const char* path) override { return ReadDirEx(path, 0); }
  int Unlink(const char* path) override { return mayWrite(path) ? inner_->Unlink(path) : refused(); }
  int Rename(const char* from, const char* to) override {
    return mayWrite(from) && mayWrite(to) ? inner_->Rename(from, to) : refused();
  }
  int Mkdir(const char* path, long mode) override { return mayWrite(path) ? inner_->Mkdir(path, mode) : refused(); }
  int Rmdir(const char* path) override { return mayWrite(path) ? inner_->Rmdir(path) : refused(); }
  int IsCaseSensitive(const char* path) override { return inner_->IsCaseSensitive(path); }
  GIntBig GetDiskFreeSpace(const char* path) override { return inner_->GetDiskFreeSpace(path); }
  int SupportsSparseFiles(const char* path) override { return inner_->SupportsSparseFiles(path); }

 private:
  static int refused() {
    errno = EACCES;
    return -1;
  }
  VSIFilesystemHandler* inner_;
};

// One that there is not, here: of the network, of standard input, of other programs.
class NoFiles final : public VSIFilesystemHandler {
 public:
  VSIVirtualHandle* Open(const char* path, const char*, bool, CSLConstList) override {
    State& s = state();
    const std::lock_guard lock(s.mutex);
    if (!s.refused) s.refused = path;
    errno = EACCES;
    return nullptr;
  }
  int Stat(const char*, VSIStatBufL*, int) override {
    errno = EACCES;
    return -1;
  }
};

struct FreeXml {
  void operator()(CPLXMLNode* node) const { CPLDestroyXMLNode(node); }
};

// The beginning of a file, or all of it up to a limit; empty if it cannot be read.
std::string textOf(const std::string& gdal_path, size_t most) {
  VSILFILE* file = VSIFOpenL(gdal_path.c_str(), "rb");
  if (file == nullptr) return {};
  std::string text;
  for (size_t block = 4096; text.size() < most; block *= 2) {
    const size_t begin = text.size(), wanted = std::min(block, most - begin);
    text.resize(begin + wanted);
    text.resize(begin + VSIFReadL(text.data() + begin, 1, wanted, file));
    if (text.size() < begin + wanted) break;
  }
  VSIFCloseL(file);
  return text;
}

// The bytes of a driver's name and the colon behind it that a name begins with; 0 if it begins with none. No expression
// of <regex>: these take a stack as deep as the name is long.
size_t driverPrefix(std::string_view name) {
  const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto isOther = [](char c) { return (c >= '0' && c <= '9') || c == '_'; };
  const size_t colon = name.find(':');
  if (colon == std::string_view::npos || colon < 2 || !isLetter(name[0])) return 0;
  const auto isOfName = [&](char c) { return isLetter(c) || isOther(c); };
  return std::ranges::all_of(name.substr(0, colon), isOfName) ? colon + 1 : 0;
}

struct VrtCheck {
  static constexpr int kMaxDepth = 8;
  static constexpr size_t kMaxBytes = 64u << 20, kMaxBlanks = 1u << 16;
  const std::string& name;  // the file that the user named
  const FileFence& fence;

  Status file(const std::string& gdal_path, int depth) const {
    // GDAL passes over blanks before it, as many as its own first look reaches.
    if (textOf(gdal_path, kMaxBlanks).find("<VRTDataset") == std::string::npos) return {};
    if (depth > kMaxDepth)
      return Error{ErrorCode::kMalformed,
                   name + ": names files that name others, more than " + std::to_string(kMaxDepth) + " deep"};
    const GdalMessages silence;
    const std::unique_ptr<CPLXMLNode, FreeXml> root(CPLParseXMLString(textOf(gdal_path, kMaxBytes).c_str()));
    return root ? node(*root, gdal_path, depth) : Status{};
  }

  // Every text of an element or attribute whose name says that it is a file's or a dataset's.
  Status node(const CPLXMLNode& first, const std::string& vrt, int depth) const {
    for (const CPLXMLNode* n = &first; n != nullptr; n = n->psNext) {
      const std::string_view key = n->pszValue == nullptr ? "" : n->pszValue;
      const bool is_named =
          n->eType == CXT_Element &&
          (key.find("Filename") != std::string_view::npos || key.find("Dataset") != std::string_view::npos ||
           key.find("FileName") != std::string_view::npos) &&
          key != "VRTDataset";
      if (is_named)
        for (const CPLXMLNode* child = n->psChild; child != nullptr; child = child->psNext)
          if (child->eType == CXT_Text)
            if (Status s = source(child->pszValue, CPLGetXMLValue(n, "relativeToVRT", "0"), vrt, depth); !s.ok())
              return s;
      if (n->psChild != nullptr)
        if (Status s = node(*n->psChild, vrt, depth); !s.ok()) return s;
    }
    return {};
  }

  Status source(const std::string& text, const std::string& relative, const std::string& vrt, int depth) const {
    if (text.find("<VRTDataset") != std::string::npos || text.find("<GDAL_WMS") != std::string::npos ||
        text.find("<WMS_") != std::string::npos)
      return Error{ErrorCode::kInvalidArgument,
                   name + ": holds another dataset as a text; write it to a file of its own"};
    Status allowed = nameOfSource(text, relative == "1", vrt);
    if (!allowed.ok()) return allowed;
    const std::string path = relative == "1" ? (std::filesystem::path(vrt).parent_path() / text).string() : text;
    return file(path, depth + 1);
  }

  // A path; or, for a driver, PREFIX:"path":variable, or PREFIX:number:path.
  Status nameOfSource(const std::string& text, bool is_relative, const std::string& vrt) const {
    const auto refused = [&] {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{}: names '{}', which is no file; name files of its folder, or below", name, text)};
    };
    if (text.find("://") != std::string::npos) return refused();
    if (text.starts_with("/vsi")) {
      if (std::ranges::none_of(kFileSystems, [&](std::string_view prefix) { return text.starts_with(prefix); }))
        return refused();
      return {};  // the archive is opened by the fenced file system
    }
    std::string path = text;
    if (const size_t prefix = driverPrefix(text); prefix > 0) {
      path = text.substr(prefix);
      if (const size_t quote = path.find('"'); quote != std::string::npos) {
        path = path.substr(quote + 1, path.find('"', quote + 1) - quote - 1);
      } else {
        // Some part of it is the path, and which is the driver's affair; so each must be allowed.
        for (size_t begin = 0; begin <= path.size();) {
          const size_t end = std::min(path.find(':', begin), path.size());
          const std::string part = path.substr(begin, end - begin);
          std::error_code failed;
          const bool is_path = part.find('/') != std::string::npos || part.find("..") != std::string::npos ||
                               std::filesystem::exists(part, failed);
          if (is_path && !fence.mayRead(part)) return FileFence::refusal(name, part);
          begin = end + 1;
        }
        return {};
      }
      if (path.find(':') != std::string::npos || path.starts_with("/vsi")) return refused();
    }
    const std::filesystem::path file =
        is_relative ? std::filesystem::path(vrt).parent_path() / path : std::filesystem::path(path);
    // Of an archive's own, which has no way out of it.
    if (vrt.starts_with("/vsi") && is_relative && path.find("..") == std::string::npos && !path.starts_with('/'))
      return {};
    if (!fence.mayRead(file)) return FileFence::refusal(name, file);
    return {};
  }
};

}  // namespace

GdalFence::GdalFence(FileFence fence) : fence_(std::move(fence)) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  ++s.fences;
  s.folders.insert(fence_.folders().begin(), fence_.folders().end());
  s.files.insert(fence_.files().begin(), fence_.files().end());
}

GdalFence::~GdalFence() {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  --s.fences;
  for (const std::filesystem::path& folder : fence_.folders()) s.folders.erase(s.folders.find(folder));
  for (const std::filesystem::path& file : fence_.files()) s.files.erase(s.files.find(file));
}

GdalOutput::GdalOutput(const std::filesystem::path& file) : file_(file) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  s.outputs.insert(file_);
}

GdalOutput::~GdalOutput() {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  s.outputs.erase(s.outputs.find(file_));
}

void closeGdalFileSystems() {
  std::vector<GDALDriverH> others;
  for (int i = 0; i < GDALGetDriverCount(); ++i)
    if (kDrivers.find(fmt::format(" {} ", GDALGetDriverShortName(GDALGetDriver(i)))) == std::string_view::npos)
      others.push_back(GDALGetDriver(i));
  for (GDALDriverH driver : others) {
    GDALDeregisterDriver(driver);
    GDALDestroyDriver(driver);
  }
  static auto* const none = new NoFiles;  // GDAL keeps file systems to its end
  static auto* const replaced = new std::vector<VSIFilesystemHandler*>;
  char** prefixes = VSIFileManager::GetPrefixes();
  for (int i = 0; prefixes != nullptr && prefixes[i] != nullptr; ++i)
    if (std::ranges::find(kFileSystems, std::string_view(prefixes[i])) == std::end(kFileSystems)) {
      replaced->push_back(VSIFileManager::GetHandler(prefixes[i]));
      VSIFileManager::InstallHandler(prefixes[i], none);
    }
  CSLDestroy(prefixes);
  VSIFileManager::InstallHandler("", new FencedFiles(VSIFileManager::GetHandler("")));
}

Status checkRefused(const GdalFence* fence, const std::string& name) {
  if (fence == nullptr) return {};
  State& s = state();
  const std::lock_guard lock(s.mutex);
  const auto refused = std::exchange(s.refused, std::nullopt);
  return refused ? Status(FileFence::refusal(name, *refused)) : Status();
}

namespace {

GdalDataset openRasters(const std::string& gdal_path) {
  return GdalDataset(GDALOpenEx(gdal_path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, nullptr,
                                nullptr, nullptr));
}

}  // namespace

Result<GdalDataset> openFenced(const GdalFence* fence, const std::string& gdal_path, const std::string& name) {
  if (fence != nullptr)
    if (Status s = VrtCheck{name, fence->files()}.file(gdal_path, 0); !s.ok()) return s.error();
  GdalDataset dataset = openRasters(gdal_path);
  if (Status s = checkRefused(fence, name); !s.ok()) return s.error();
  return dataset;
}

Result<GdalDataset> openSubdataset(const GdalFence* fence, const std::string& subdataset, const std::string& gdal_path,
                                   const std::string& name) {
  if (fence != nullptr) {
    if (subdataset.find(gdal_path) == std::string::npos)
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{}: names '{}' as its variable, which is another file", name, subdataset)};
    if (Status s = VrtCheck{name, fence->files()}.nameOfSource(subdataset, false, gdal_path); !s.ok()) return s.error();
  }
  return openRasters(subdataset);
}

}  // namespace foreland::terrain
