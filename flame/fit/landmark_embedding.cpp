#include "flame/fit/landmark_embedding.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "splat/base/error.h"
#include "splat/base/npz.h"

namespace cosplat {
namespace {

constexpr int kFlameVertices = 5023;

// MediaPipe's landmarks on FLAME's mesh. From FLAME 2023 Open, (c) Max Planck Institute for
// Intelligent Systems, CC-BY-4.0; faces are written as their vertices, coordinates rounded.
// clang-format off
constexpr struct {
  int landmark;
  int vertices[3];
  double barycentric[3];
} kMediapipePoints[] = {
    {0, {1657, 3541, 3543}, {0.0000, 0.5095, 0.4905}},
    {2, {1692, 3556, 3507}, {0.0001, 0.7824, 0.2175}},
    {4, {3564, 3563, 1817}, {0.8387, 0.1607, 0.0006}},
    {5, {1818, 3508, 3526}, {0.0004, 0.9173, 0.0823}},
    {6, {3518, 738, 3516}, {0.8947, 0.0032, 0.1021}},
    {7, {2271, 2264, 2268}, {0.5769, 0.4231, 0.0000}},
    {13, {1669, 3531, 3533}, {0.0000, 0.7311, 0.2689}},
    {14, {1849, 3504, 3506}, {0.0000, 0.9709, 0.0291}},
    {17, {3503, 3511, 1866}, {0.2216, 0.7784, 0.0000}},
    {33, {2448, 2447, 2425}, {0.2104, 0.7896, 0.0000}},
    {37, {2810, 2774, 2775}, {0.4661, 0.2011, 0.3328}},
    {39, {2811, 2812, 2813}, {0.0502, 0.7573, 0.1925}},
    {40, {2850, 2864, 2834}, {0.1367, 0.5487, 0.3146}},
    {46, {2567, 3159, 2578}, {0.7247, 0.2493, 0.0260}},
    {52, {335, 337, 338}, {0.0080, 0.1371, 0.8549}},
    {53, {2562, 337, 2566}, {0.0992, 0.4993, 0.4015}},
    {55, {3684, 3788, 3741}, {0.1511, 0.0306, 0.8183}},
    {61, {2820, 2819, 2712}, {0.2119, 0.7560, 0.0321}},
    {63, {3157, 3706, 3708}, {0.9319, 0.0628, 0.0053}},
    {65, {3154, 338, 3696}, {0.6087, 0.0416, 0.3497}},
    {66, {3154, 3705, 3153}, {0.4431, 0.0164, 0.5405}},
    {70, {3708, 2189, 3763}, {0.0608, 0.6257, 0.3135}},
    {78, {2712, 2715, 2828}, {0.0173, 0.5560, 0.4267}},
    {80, {2852, 2851, 2853}, {0.5990, 0.2948, 0.1062}},
    {81, {2787, 2865, 2849}, {0.7947, 0.0266, 0.1787}},
    {82, {2865, 2787, 2786}, {0.0067, 0.0524, 0.9409}},
    {84, {2905, 2904, 2949}, {0.0794, 0.0904, 0.8302}},
    {87, {2938, 2928, 2907}, {0.7891, 0.0738, 0.1371}},
    {88, {2896, 2890, 2895}, {0.4924, 0.1418, 0.3658}},
    {91, {2899, 2881, 2878}, {0.2713, 0.3778, 0.3509}},
    {95, {2895, 2891, 2894}, {0.4238, 0.2547, 0.3215}},
    {97, {2791, 2793, 2790}, {0.5890, 0.3191, 0.0919}},
    {98, {2788, 2751, 2740}, {0.4979, 0.4889, 0.0132}},
    {105, {335, 336, 337}, {0.6784, 0.1359, 0.1857}},
    {107, {3712, 2178, 2177}, {0.3695, 0.4180, 0.2125}},
    {129, {2741, 2740, 3092}, {0.6612, 0.2979, 0.0409}},
    {133, {2517, 2518, 2520}, {0.2357, 0.3872, 0.3771}},
    {144, {2355, 2358, 2295}, {0.0114, 0.8182, 0.1704}},
    {145, {2294, 2290, 2293}, {0.0365, 0.6534, 0.3101}},
    {146, {2878, 2880, 2879}, {0.0035, 0.3468, 0.6497}},
    {153, {2293, 2298, 2299}, {0.5826, 0.2620, 0.1554}},
    {154, {2304, 2503, 2305}, {0.6459, 0.2123, 0.1418}},
    {155, {2504, 2523, 2518}, {0.0894, 0.2963, 0.6143}},
    {157, {2492, 2491, 2486}, {0.0000, 0.1614, 0.8386}},
    {158, {2493, 3689, 2494}, {0.0000, 0.2559, 0.7441}},
    {159, {3689, 2495, 2473}, {0.4867, 0.5133, 0.0000}},
    {160, {2381, 2451, 2453}, {0.0000, 0.2238, 0.7762}},
    {161, {2450, 2452, 2451}, {0.6203, 0.0000, 0.3797}},
    {163, {2359, 2269, 2267}, {0.7078, 0.0000, 0.2922}},
    {168, {703, 3553, 3560}, {0.0006, 0.4781, 0.5213}},
    {173, {3632, 2488, 2487}, {0.4600, 0.0000, 0.5400}},
    {178, {2907, 2892, 2896}, {0.6215, 0.2481, 0.1304}},
    {181, {2904, 2898, 2899}, {0.5781, 0.2488, 0.1731}},
    {185, {2834, 2826, 2831}, {0.0326, 0.0045, 0.9629}},
    {191, {2853, 2848, 2837}, {0.2162, 0.4301, 0.3537}},
    {195, {1757, 3521, 3501}, {0.0019, 0.4412, 0.5569}},
    {197, {1895, 3561, 3548}, {0.0029, 0.0551, 0.9420}},
    {246, {2441, 2448, 2449}, {0.0000, 0.1174, 0.8826}},
    {249, {815, 807, 822}, {0.0000, 0.4231, 0.5769}},
    {263, {1200, 1151, 1195}, {0.2104, 0.0000, 0.7896}},
    {267, {1693, 1658, 1657}, {0.4661, 0.3328, 0.2011}},
    {269, {1695, 1694, 1696}, {0.7573, 0.0502, 0.1925}},
    {270, {1735, 1717, 1749}, {0.1367, 0.3146, 0.5487}},
    {276, {1430, 1441, 2140}, {0.7247, 0.0260, 0.2493}},
    {282, {16, 27, 18}, {0.0080, 0.8549, 0.1371}},
    {283, {18, 1425, 1429}, {0.4993, 0.0992, 0.4015}},
    {285, {3851, 3880, 3912}, {0.1511, 0.8183, 0.0306}},
    {291, {1703, 1576, 1702}, {0.2119, 0.0321, 0.7560}},
    {293, {2138, 3865, 3864}, {0.9319, 0.0053, 0.0628}},
    {295, {2135, 3859, 27}, {0.6087, 0.3497, 0.0416}},
    {296, {3863, 2135, 2134}, {0.0164, 0.4431, 0.5405}},
    {300, {3865, 3892, 694}, {0.0608, 0.3135, 0.6257}},
    {308, {1711, 1579, 1576}, {0.4267, 0.5560, 0.0173}},
    {310, {1737, 1738, 1736}, {0.5990, 0.1061, 0.2949}},
    {311, {1670, 1734, 1750}, {0.7947, 0.1787, 0.0266}},
    {312, {1750, 1669, 1670}, {0.0067, 0.9409, 0.0524}},
    {314, {1802, 1866, 1801}, {0.0794, 0.8302, 0.0904}},
    {317, {1826, 1849, 1804}, {0.0738, 0.7891, 0.1371}},
    {318, {1787, 1793, 1792}, {0.1418, 0.4924, 0.3658}},
    {321, {1774, 1796, 1770}, {0.3778, 0.2713, 0.3509}},
    {324, {1792, 1791, 1788}, {0.4238, 0.3215, 0.2547}},
    {326, {1676, 1674, 1673}, {0.3191, 0.5890, 0.0919}},
    {327, {1671, 1604, 1623}, {0.4979, 0.0132, 0.4889}},
    {334, {16, 18, 17}, {0.6784, 0.1858, 0.1358}},
    {336, {672, 673, 3868}, {0.2126, 0.4180, 0.3694}},
    {358, {2057, 1604, 1605}, {0.0408, 0.2979, 0.6613}},
    {362, {1371, 1369, 1368}, {0.3772, 0.3872, 0.2356}},
    {373, {883, 994, 991}, {0.1705, 0.8182, 0.0113}},
    {374, {882, 881, 878}, {0.0365, 0.3101, 0.6534}},
    {375, {1773, 1770, 1771}, {0.3468, 0.0035, 0.6497}},
    {380, {881, 897, 896}, {0.5826, 0.1555, 0.2619}},
    {381, {904, 905, 1352}, {0.6459, 0.1418, 0.2123}},
    {382, {1374, 1353, 1369}, {0.2963, 0.0894, 0.6143}},
    {384, {1341, 1331, 1340}, {0.0000, 0.8386, 0.1614}},
    {385, {1342, 1343, 3855}, {0.0000, 0.7441, 0.2559}},
    {386, {3855, 1294, 1344}, {0.4867, 0.0000, 0.5133}},
    {387, {1224, 1216, 1218}, {-0.0000, 0.2238, 0.7762}},
    {388, {1217, 1202, 1216}, {0.0000, 0.6203, 0.3797}},
    {390, {816, 995, 814}, {0.0000, 0.7078, 0.2922}},
    {398, {3833, 1336, 1337}, {0.4600, 0.5400, 0.0000}},
    {402, {1789, 1804, 1793}, {0.2481, 0.6215, 0.1304}},
    {405, {1795, 1801, 1796}, {0.2488, 0.5781, 0.1731}},
    {409, {1717, 1714, 1709}, {0.0326, 0.9629, 0.0045}},
    {415, {1738, 1720, 1733}, {0.2162, 0.3537, 0.4301}},
    {466, {1201, 1200, 1183}, {0.8826, 0.1174, -0.0000}},
};

// Landmarks of the forehead and the chin, where they lie on average over two tracked heads. They
// slide, but they are far out, and say how large the head is.
constexpr double kOutlineLooseness = 3;
constexpr struct {
  int landmark;
  int vertices[3];
  double barycentric[3];
} kOutlinePoints[] = {
    {10, {3520, 2187, 3505}, {0.3, 0.0, 0.7}},
    {67, {3172, 2608, 3173}, {0.3, 0.0, 0.7}},
    {103, {2953, 3155, 2609}, {0.3, 0.1, 0.6}},
    {109, {2000, 3782, 2186}, {0.3, 0.1, 0.6}},
    {136, {3389, 3479, 3390}, {0.9, 0.1, 0.0}},
    {148, {3397, 3398, 3396}, {0.7, 0.1, 0.2}},
    {149, {3391, 3393, 3394}, {0.5, 0.5, 0.0}},
    {150, {3418, 3392, 3391}, {0.6, 0.2, 0.2}},
    {152, {3399, 3601, 3400}, {0.9, 0.0, 0.1}},
    {176, {3394, 3395, 3396}, {0.4, 0.5, 0.1}},
    {297, {2161, 2160, 3885}, {0.7, 0.2, 0.1}},
    {332, {1871, 1472, 2136}, {0.3, 0.6, 0.1}},
    {338, {3908, 573, 691}, {0.1, 0.3, 0.6}},
    {365, {3740, 3587, 3588}, {0.1, 0.8, 0.1}},
    {377, {3600, 3599, 3601}, {0.7, 0.3, 0.0}},
    {378, {3593, 3595, 3594}, {0.6, 0.4, 0.0}},
    {379, {3637, 3593, 3594}, {0.6, 0.3, 0.1}},
    {400, {3596, 3599, 3598}, {0.5, 0.1, 0.4}},
};
// clang-format on

// The frontmost vertices of the eyeballs, where the irises' centres are seen.
constexpr struct { int landmark, vertex; } kPupils[] = {{468, 4597}, {473, 4051}};

// MediaPipe's landmark at each of iBUG's points from the 18th on: brows, nose, eyes, lips. The 17
// points of the jaw slide along the outline as the head turns, and have no place on the mesh.
constexpr int kIbugFirst = 17;
constexpr int kMediapipeOfIbug[] = {70,  63,  105, 66,  107, 336, 296, 334, 293, 300, 168, 197, 5,
                                    4,   75,  97,  2,   326, 305, 33,  160, 158, 133, 153, 144, 362,
                                    385, 387, 263, 373, 380, 61,  39,  37,  0,   267, 269, 291, 405,
                                    314, 17,  84,  181, 78,  82,  13,  312, 308, 317, 14,  87};

void CheckTopology(const FlameModel& model) {
  std::set<std::array<int, 3>> faces;
  for (const std::array<int32_t, 3>& face : model.faces) {
    std::array<int, 3> sorted{face[0], face[1], face[2]};
    std::sort(sorted.begin(), sorted.end());
    faces.insert(sorted);
  }
  bool same = model.own_vertex_count() == kFlameVertices;
  for (const auto& point : kMediapipePoints) {
    std::array<int, 3> sorted{point.vertices[0], point.vertices[1], point.vertices[2]};
    std::sort(sorted.begin(), sorted.end());
    same = same && faces.count(sorted) != 0;
  }
  if (!same)
    throw Error(model.name,
                "faces",
                "are not FLAME's (" + std::to_string(model.own_vertex_count()) +
                    " vertices): an embedding of the landmarks in this mesh is needed "
                    "(--landmark-embedding)");
}

LandmarkEmbedding MediapipeLandmarks(bool with_irises) {
  LandmarkEmbedding embedding;
  for (const auto& [landmark, v, b] : kMediapipePoints)
    embedding.push_back({landmark, {v[0], v[1], v[2]}, {b[0], b[1], b[2]}});
  const double loose = getenv("FIT_OUT") ? atof(getenv("FIT_OUT")) : kOutlineLooseness;
  for (const auto& [landmark, v, b] : kOutlinePoints)
    if (loose > 0) embedding.push_back({landmark, {v[0], v[1], v[2]}, {b[0], b[1], b[2]}, loose});
  for (const auto& [landmark, v] : kPupils)
    if (with_irises) embedding.push_back({landmark, {v, v, v}, {1, 0, 0}});
  return embedding;
}

// Checks that values[i] is a whole number of [0, end).
int IndexIn(const Npz& npz, const std::string& array, size_t i, int end) {
  const double value = npz.Get(array).values[i];
  if (!(value >= 0 && value < end && value == std::floor(value)))
    throw Error(npz.path(),
                array + "[" + std::to_string(i) + "]",
                "is " + std::to_string(value) + ", expected 0 to " + std::to_string(end - 1));
  return int(value);
}

std::array<double, 3> BarycentricIn(const Npz& npz, size_t i) {
  const double* b = &npz.Get("lmk_b_coords").values[3 * i];
  if (!(std::abs(b[0] + b[1] + b[2] - 1) < 1e-2))
    throw Error(npz.path(), "lmk_b_coords[" + std::to_string(i) + "]", "does not sum to 1");
  return {b[0], b[1], b[2]};
}

}  // namespace

LandmarkEmbedding FlameLandmarks(const FlameModel& model, LandmarkSet set) {
  CheckTopology(model);
  const LandmarkEmbedding all = MediapipeLandmarks(set == LandmarkSet::kMediapipe478);
  if (set != LandmarkSet::kIbug68) return all;
  LandmarkEmbedding ibug;
  for (size_t i = 0; i < std::size(kMediapipeOfIbug); ++i)
    for (EmbeddedLandmark point : all)
      if (point.landmark == kMediapipeOfIbug[i]) {
        point.landmark = kIbugFirst + int(i);
        ibug.push_back(point);
      }
  return ibug;
}

LandmarkEmbedding ReadLandmarkEmbedding(const std::string& path,
                                        const FlameModel& model,
                                        int point_count) {
  const Npz npz = Npz::Read(path);
  const long count = long(npz.Get("landmark_indices", {-1}).size());
  npz.Get("lmk_face_idx", {count});
  npz.Get("lmk_b_coords", {count, 3});
  LandmarkEmbedding embedding;
  for (size_t i = 0; i < size_t(count); ++i) {
    const int face = IndexIn(npz, "lmk_face_idx", i, int(model.faces.size()));
    const std::array<int32_t, 3>& v = model.faces[size_t(face)];
    embedding.push_back({IndexIn(npz, "landmark_indices", i, point_count),
                         {v[0], v[1], v[2]},
                         BarycentricIn(npz, i)});
  }
  return embedding;
}

}  // namespace cosplat
