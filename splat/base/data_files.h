// The files of a data set as people keep them: names that the data give, with another machine's
// folders, without an ending or with another one, are found in the data set's own folders. Used by
// all layouts.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace cosplat {

// Endings of image files that ReadImage decodes, in the order in which one of several is taken.
bool IsImageName(const std::string& name);  // by its ending, whatever its case

// Without a drive, with forward slashes: "D:\data\r_0.png" -> "/data/r_0.png".
std::string ForwardSlashes(const std::string& named);
// The name without its folders and its image ending: "images\r_0.JPG" -> "r_0".
std::string StemOf(const std::string& named);

// Looks into each folder once. Not thread-safe.
class DataFiles {
 public:
  explicit DataFiles(const std::string& root) : root_(root) {}
  // The file that `named` means: root/named; else the longest end of it, whole folders at a time,
  // that exists below the root ("/home/ann/fox/images/1.png" -> root/images/1.png). Empty: none. An
  // absolute name counts as it is only inside the root.
  std::string Find(const std::string& named);
  // The same of an image, whose ending may be another one, absent, or in another case.
  std::string FindImage(const std::string& named);

 private:
  using Names = std::map<std::string, std::vector<std::string>>;  // by lower-case stem

  std::string root_;
  std::map<std::string, Names> folders_;

  const Names& NamesIn(const std::string& folder);
  std::string ImageAt(const std::string& path);
  template <class Exists>
  std::string LongestEnd(const std::string& named, const Exists& exists);
};

}  // namespace cosplat
