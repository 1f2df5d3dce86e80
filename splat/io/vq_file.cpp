#include "splat/io/vq_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include "splat/base/error.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

constexpr const char* kHeader = "splats.json";
constexpr const char* kLayout = "cosplat-splats";
constexpr int kVersion = 1;

std::string OfDegree(const std::string& name, int degree) {
  return name + "_" + std::to_string(degree);
}

// The members of a file, checked as they are read.
class Members {
 public:
  explicit Members(const std::string& path) : npz_(Npz::Read(path)) {}

  Json Header() const {
    const Json json = Json::parse(npz_.Text(kHeader), nullptr, false);
    if (json.is_discarded()) Fail(kHeader, "is not JSON");
    return json;
  }
  const NpyArray& Array(const std::string& name, const std::vector<long>& shape) {
    taken_.insert(name);
    return npz_.Get(name, shape);
  }
  std::vector<float> Floats(const std::string& name, const std::vector<long>& shape) {
    const NpyArray& array = Array(name, shape);
    std::vector<float> values;
    values.reserve(array.size());
    for (size_t i = 0; i < array.size(); ++i) {
      if (!std::isfinite(float(array.values[i])))
        Fail(name, "number " + std::to_string(i) + " is not finite");
      values.push_back(float(array.values[i]));
    }
    return values;
  }
  // Integers in 0 .. `end` - 1.
  template <class T>
  std::vector<T> Integers(const std::string& name,
                          const std::vector<long>& shape,
                          size_t end,
                          const std::string& expected) {
    const NpyArray& array = Array(name, shape);
    std::vector<T> values;
    values.reserve(array.size());
    for (size_t i = 0; i < array.size(); ++i) {
      const double value = array.values[i];
      if (!(value >= 0 && value < double(end) && value == std::floor(value)))
        Fail(
            name,
            "number " + std::to_string(i) + " is " + Json(value).dump() + ", expected " + expected);
      values.push_back(T(value));
    }
    return values;
  }
  // The arrays that have not been read.
  Npz Rest() const {
    Npz rest(npz_.path());
    for (const auto& [name, array] : npz_.arrays())
      if (!taken_.count(name)) rest.Add(name, array);
    return rest;
  }
  [[noreturn]] void Fail(const std::string& member, const std::string& problem) const {
    throw Error(npz_.path(), member, problem);
  }

 private:
  Npz npz_;
  std::set<std::string> taken_;
};

struct Header {
  std::string kind;
  long count;
  int degree;
  bool antialiased;
};

Header ReadHeader(const std::string& path, const Members& members) {
  const Json json = members.Header();
  const JsonField header(path + ": " + kHeader, json);
  const std::string layout = header["layout"].String();
  if (layout != kLayout)
    members.Fail(kHeader, "layout is '" + layout + "', expected '" + kLayout + "'");
  const int version = header["version"].Integer();
  if (version != kVersion)
    members.Fail(kHeader, "version is " + std::to_string(version) + ", this program reads 1");
  const int degree = header["degree"].Integer();
  if (degree < 0 || degree > kMaxTrainedDegree)
    members.Fail(kHeader, "degree is " + std::to_string(degree) + ", expected 0 to 4");
  const int count = header["count"].Integer();
  if (count < 0) members.Fail(kHeader, "count is " + std::to_string(count));
  const bool antialiased = header.Has("antialiased") && header["antialiased"].raw() == true;
  return {header["kind"].String(), count, degree, antialiased};
}

// Number of splats that have this degree and are quantised (1) or kept (0).
long CountOf(const QuantisedSplats& splats, int degree, uint8_t quantised) {
  long count = 0;
  for (size_t i = 0; i < splats.size(); ++i)
    count += splats.own_degree[i] == degree && splats.quantised[i] == quantised;
  return count;
}

QuantisedBands ReadBands(Members& members, const QuantisedSplats& splats, int degree) {
  const long kept = CountOf(splats, degree, 0), quantised = CountOf(splats, degree, 1);
  QuantisedBands bands;
  if (kept + quantised == 0) return bands;
  const long coefficients = CoefficientCount(degree) - 1;
  bands.kept = members.Floats(OfDegree("kept", degree), {kept, coefficients, 3});
  const std::string codebook = OfDegree("codebook", degree);
  bands.codebook = members.Floats(codebook, {-1, coefficients, 3});
  const size_t entries = bands.codebook.size() / size_t(3 * coefficients);
  bands.index =
      members.Integers<uint16_t>(OfDegree("index", degree),
                                 {quantised},
                                 entries,
                                 "a row of the " + std::to_string(entries) + " of " + codebook);
  return bands;
}

}  // namespace

Gaussians Dequantise(const QuantisedSplats& splats) {
  Gaussians g;
  g.degree = splats.degree;
  g.basis = Basis::kSh;
  g.antialiased = splats.antialiased;
  g.Resize(splats.size());
  const auto copy = [&](Attribute attribute, const std::vector<float>& values) {
    std::copy(values.begin(), values.end(), g.values[attribute].begin());
  };
  copy(kPosition, splats.position);
  copy(kRotation, splats.rotation);
  copy(kScaleLog, splats.scale_log);
  copy(kOpacityLogit, splats.opacity_logit);
  copy(kColorDc, splats.color_dc);
  struct Next {
    size_t kept = 0, quantised = 0;
  };
  std::array<Next, kMaxTrainedDegree + 1> next;
  for (size_t i = 0; i < g.size(); ++i) {
    const int degree = splats.own_degree[i];
    if (degree == 0) continue;
    const QuantisedBands& bands = splats.bands[degree];
    const size_t width = 3 * size_t(CoefficientCount(degree) - 1);
    const float* own = splats.quantised[i]
                           ? &bands.codebook[bands.index[next[degree].quantised++] * width]
                           : &bands.kept[next[degree].kept++ * width];
    std::copy_n(own, width, g.at(kColorRest, i));
  }
  return g;
}

void WriteVqFile(const std::string& path, const QuantisedSplats& s) {
  const size_t n = s.size();
  for (size_t i = 0; i < s.position.size(); ++i)
    if (!std::isfinite(s.position[i]))
      throw Error(path, "position", "number " + std::to_string(i) + " is not finite");
  Npz npz(path);
  Json header{{"layout", kLayout},
              {"version", kVersion},
              {"kind", s.kind},
              {"count", n},
              {"degree", s.degree},
              {"basis", "sh"}};
  if (s.antialiased) header["antialiased"] = true;
  npz.AddText(kHeader, header.dump() + "\n");
  npz.Add("position", {n, 3}, s.position);
  npz.AddHalf("rotation", {n, 4}, s.rotation);
  npz.AddHalf("scale_log", {n, 3}, s.scale_log);
  npz.AddHalf("opacity_logit", {n}, s.opacity_logit);
  npz.AddHalf("color_dc", {n, 3}, s.color_dc);
  npz.Add("degree", {n}, s.own_degree);
  npz.Add("quantised", {n}, s.quantised);
  for (int degree = 1; degree <= kMaxTrainedDegree; ++degree) {
    const size_t kept = size_t(CountOf(s, degree, 0)), quantised = size_t(CountOf(s, degree, 1));
    if (kept + quantised == 0) continue;
    const size_t coefficients = size_t(CoefficientCount(degree) - 1);
    const QuantisedBands& c = s.bands[degree];
    npz.AddHalf(OfDegree("kept", degree), {kept, coefficients, 3}, c.kept);
    npz.Add(OfDegree("index", degree), {quantised}, c.index);
    const size_t entries = c.codebook.size() / (3 * coefficients);
    npz.AddHalf(OfDegree("codebook", degree), {entries, coefficients, 3}, c.codebook);
  }
  for (const auto& [name, array] : s.more.arrays()) npz.Add(name, array);
  npz.Write(path);
}

QuantisedSplats ReadVqFile(const std::string& path) {
  Members members(path);
  const auto [kind, n, degree, antialiased] = ReadHeader(path, members);
  QuantisedSplats splats;
  splats.antialiased = antialiased;
  splats.kind = kind;
  splats.degree = degree;
  splats.position = members.Floats("position", {n, 3});
  splats.rotation = members.Floats("rotation", {n, 4});
  splats.scale_log = members.Floats("scale_log", {n, 3});
  splats.opacity_logit = members.Floats("opacity_logit", {n});
  splats.color_dc = members.Floats("color_dc", {n, 3});
  splats.own_degree = members.Integers<uint8_t>(
      "degree", {n}, size_t(degree) + 1, "0 to " + std::to_string(degree));
  splats.quantised = members.Integers<uint8_t>("quantised", {n}, 2, "0 or 1");
  for (int d = 1; d <= degree; ++d) splats.bands[d] = ReadBands(members, splats, d);
  splats.more = members.Rest();
  return splats;
}

bool IsVqFile(const std::string& path) {
  // The name of a zip's first member follows its local header of 30 bytes.
  constexpr size_t kLocalHeader = 30;
  const std::string name = kHeader;
  std::string bytes(kLocalHeader + name.size(), '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), std::streamsize(bytes.size()));
  return bytes.starts_with("PK\x03\x04") && bytes.substr(kLocalHeader) == name;
}

}  // namespace cosplat
