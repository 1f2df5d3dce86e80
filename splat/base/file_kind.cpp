#include <algorithm>
#include <cctype>

#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// ISO media files (HEIF, AVIF) name their brand after "ftyp".
std::string IsoImage(std::string_view begin) {
  if (begin.substr(0, 8).substr(std::min<size_t>(4, begin.size())) != "ftyp") return "";
  const std::string_view brand = begin.substr(8, 4);
  if (brand == "avif" || brand == "avis")
    return "is an AVIF image, which is not read: convert it to PNG or JPEG (ffmpeg -i FILE "
           "FILE.png)";
  for (const char* heif : {"heic", "heix", "hevc", "heim", "heis", "mif1", "msf1"})
    if (brand == heif)
      return "is a HEIC image, which is not read: convert it to JPEG (heif-convert FILE FILE.jpg)";
  if (brand == "crx ") return kRawImage;  // Canon's CR3
  return "is a video, not an image";
}

}  // namespace

std::string OtherContent(std::string_view begin) {
  if (begin.empty()) return "is empty";
  std::string text = LowerCase(std::string(begin));
  text.erase(0, text.find_first_not_of(" \t\r\n\xef\xbb\xbf"));
  if (text.starts_with("version https://git-lfs"))
    return "is a pointer of Git LFS, not the file itself: `git lfs pull` fetches it";
  if (text.starts_with("<svg")) return "is a drawing in SVG: convert it to PNG";
  for (const char* page : {"<!doctype", "<!--", "<html", "<?xml", "<head", "404: not found"})
    if (text.starts_with(page))
      return "is a web page, such as a log-in or an error, not the file itself: download it again";
  if (text.starts_with("%pdf")) return "is a PDF document";
  if (begin.starts_with("\x93NUMPY"))
    return "is one NumPy array (.npy), not an archive of them (.npz); a landmark embedding is not "
           "needed, "
           "the program has its own";
  using namespace std::string_view_literals;
  if (begin.starts_with("\xff\x0a") || begin.starts_with("\0\0\0\x0cJXL "sv))
    return "is a JPEG XL image, which is not read: convert it to PNG (djxl FILE FILE.png)";
  if (begin.starts_with("II*\0\x10\0\0\0CR"sv) || begin.starts_with("FUJIFILM") ||
      begin.starts_with("IIRO") || begin.starts_with("IIU\0"sv))
    return kRawImage;
  return IsoImage(begin);
}

}  // namespace cosplat
