#include "tests/fuzz/reader.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/zip_archive.h"
#include "tests/support/glb_bytes.h"
#include "tests/support/stored_zip.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

// Without a temporary name and fsync, which would take most of the time.
void Spill(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

std::string AsZip(const std::vector<std::string>& parts) {
  std::vector<std::pair<std::string, std::string>> members;
  for (size_t i = 0; i + 1 < parts.size(); i += 2)
    members.emplace_back(parts[i].substr(0, 1000), parts[i + 1]);
  return StoredZip(members);
}

std::string WithChecksum(std::string bytes) {
  if (bytes.size() < sizeof(uint32_t)) return bytes;
  const size_t end = bytes.size() - sizeof(uint32_t);
  const uint32_t crc = cosplat::Crc32(bytes.data(), end);
  std::memcpy(bytes.data() + end, &crc, sizeof crc);
  return bytes;
}

}  // namespace

const char* const kPartMark = "\n%%%%\n";

const std::vector<FuzzedReader>& FuzzedReaders() {
  static const std::vector<FuzzedReader> all = [] {
    std::vector<FuzzedReader> readers;
    for (auto part : {SplatReaders(), HeadReaders(), LiveReaders(), RunReaders()})
      readers.insert(readers.end(), part.begin(), part.end());
    return readers;
  }();
  return all;
}

std::string JoinParts(const std::vector<std::string>& parts) {
  std::string bytes;
  for (size_t i = 0; i < parts.size(); ++i) bytes += (i == 0 ? "" : kPartMark) + parts[i];
  return bytes;
}

std::vector<std::string> SplitParts(const std::string& bytes) {
  std::vector<std::string> parts;
  size_t begin = 0;
  for (size_t end; (end = bytes.find(kPartMark, begin)) != std::string::npos;
       begin = end + std::strlen(kPartMark))
    parts.push_back(bytes.substr(begin, end - begin));
  parts.push_back(bytes.substr(begin));
  return parts;
}

std::string PartsOfZip(const std::string& path) {
  const ZipReader zip(path, "ZIP archive");
  std::vector<std::string> parts;
  for (size_t i = 0; i < zip.size(); ++i) {
    const std::vector<char> member = zip.Read(i);
    parts.push_back(zip.Name(i));
    parts.emplace_back(member.begin(), member.end());
  }
  return JoinParts(parts);
}

std::string Slurped(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

std::vector<std::string> NpzSeeds(const Npz& npz) {
  const TemporaryFolder folder;
  npz.Write(folder / "a.npz");
  return {PartsOfZip(folder / "a.npz")};
}

std::vector<std::string> NpyWords() {
  return {"\x93NUMPY\x01",
          "'descr': '<f4'",
          "'<f2'",
          "'|u1'",
          "'<i8'",
          "'>f4'",
          "'fortran_order': True",
          "'shape': (1, 3), ",
          "(99999999999,)",
          ".npy"};
}

ReaderRun::ReaderRun(const FuzzedReader& reader, std::string folder)
    : reader_(reader), folder_(std::move(folder)) {
  for (const std::string& file : reader.files)
    MakeDirectories(std::filesystem::path(folder_ + "/" + file).parent_path().string());
  if (reader.prepare) reader.prepare(folder_);
}

void ReaderRun::Place(const std::string& bytes) const {
  const std::vector<std::string> parts = SplitParts(bytes);
  const auto path = [&](size_t i) { return folder_ + "/" + reader_.files[i]; };
  switch (reader_.placing) {
    case Placing::kFiles:
      for (size_t i = 0; i < reader_.files.size(); ++i)
        if (reader_.files.size() == 1)
          Spill(path(0), bytes);
        else if (i < parts.size())
          Spill(path(i), parts[i]);
        else
          std::filesystem::remove(path(i));
      return;
    case Placing::kZip:
      return Spill(path(0), AsZip(parts));
    case Placing::kGzip:
      return Spill(path(0), Gzip(bytes));
    case Placing::kGlb:
      return Spill(path(0), JoinGlb(parts[0], parts.size() > 1 ? parts[1] : ""));
    case Placing::kChecksummed:
      return Spill(path(0), WithChecksum(bytes));
  }
}

std::string ReaderRun::Problem(const std::string& bytes, bool& good) {
  good = false;
  Place(bytes);
  try {
    const std::string problem = reader_.read(folder_, bytes);
    good = problem.empty();
    return problem;
  } catch (const Error& error) {
    const std::string& text = refusal_ = error.what();
    if (text.find('\n') != std::string::npos) return "an error of two lines: " + text;
    return text.size() > 1000 ? "an error without an end: " + text : "";
  } catch (const std::exception& other) {
    return std::string("not an Error: ") + other.what();
  }
}

}  // namespace cosplat::test
