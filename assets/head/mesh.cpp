#include "assets/head/mesh.h"

#include <algorithm>
#include <cmath>

#include "assets/head/mesh_builder.h"

namespace cosplat::procedural {
namespace {

constexpr int kColumns = 64;  // around the head, 0 at the front, growing towards +x
constexpr int kHalf = kColumns / 2;
constexpr int kRows = 48;           // from the crown's cap down to the cut below the shoulders
constexpr int kCap = kColumns / 4;  // the crown is a square patch of kCap x kCap cells
constexpr float kAxisZ = -0.035f;

// A rectangle of cells omitted from the grid, to be filled by rings.
struct Block {
  int column_begin, column_end, row_begin, row_end;  // grid lines, inclusive
};
constexpr Block kLeftEyeBlock{3, 12, 6, 14};
constexpr Block kRightEyeBlock{-12, -3, 6, 14};
constexpr Block kMouthBlock{-7, 7, 21, 29};
constexpr Block kLeftEarBlock{17, 22, 7, 19};
constexpr Block kRightEarBlock{-22, -17, 7, 19};
constexpr Block kBlocks[] = {
    kLeftEyeBlock, kRightEyeBlock, kMouthBlock, kLeftEarBlock, kRightEarBlock};

int Column(int i) { return ((i % kColumns) + kColumns) % kColumns; }
int Signed(int i) { return i > kHalf ? i - kColumns : i; }

bool InsideBlock(int column, int row) {
  for (const Block& b : kBlocks)
    if (column > b.column_begin && column < b.column_end && row > b.row_begin && row < b.row_end)
      return true;
  return false;
}
bool CellInBlock(int column, int row) {  // the cell right of `column` and below `row`
  for (const Block& b : kBlocks)
    if (column >= b.column_begin && column < b.column_end && row >= b.row_begin && row < b.row_end)
      return true;
  return false;
}

// A piecewise linear table.
struct Key {
  float at, value;
};
template <size_t N>
float Lookup(const Key (&keys)[N], float at) {
  size_t k = 0;
  while (k + 2 < N && at > keys[k + 1].at) ++k;
  const float t = std::clamp((at - keys[k].at) / (keys[k + 1].at - keys[k].at), 0.0f, 1.0f);
  return keys[k].value + t * (keys[k + 1].value - keys[k].value);
}

// A column's angle about the vertical axis: dense at nose, eyes and mouth.
float ColumnAngle(int column) {
  static constexpr Key kAngle[] = {{0, 0}, {3, 6.5f}, {12, 40}, {17, 74}, {22, 112}, {32, 180}};
  const int s = Signed(Column(column));
  return (s < 0 ? -1.0f : 1.0f) * Lookup(kAngle, float(std::abs(s))) * kDegree;
}

// Origin and elevation of a row's ray, at the front and towards the side and back.
struct RowRay {
  float y, elevation, z;
};
RowRay FrontRay(float row) {
  static constexpr Key kY[] = {{0, .055f},
                               {6, .0600f},
                               {14, .008f},
                               {16, .010f},
                               {21, .010f},
                               {29, -.062f},
                               {32, -.060f},
                               {37, -.050f},
                               {39, -.098f},
                               {44, -.135f},
                               {47, kBustBottom}};
  // Rows 16 to 21 look from below at the underside of the nose, rows 32 to 38 at that of the chin.
  static constexpr Key kElevation[] = {{0, 50},
                                       {6, 0},
                                       {14, 0},
                                       {16, -4.5f},
                                       {18, -9.7f},
                                       {21, -17.4f},
                                       {29, 0},
                                       {32, -20},
                                       {37, -44},
                                       {39, -12},
                                       {44, 0},
                                       {47, 0}};
  static constexpr Key kZ[] = {
      {0, kAxisZ}, {29, kAxisZ}, {32, -.002f}, {37, -.042f}, {39, -.045f}, {47, -.050f}};
  return {Lookup(kY, row), Lookup(kElevation, row) * kDegree, Lookup(kZ, row)};
}
RowRay SideRay(float row) {
  static constexpr Key kY[] = {{0, .055f},
                               {6, .060f},
                               {14, .020f},
                               {21, -.012f},
                               {29, -.036f},
                               {33, -.050f},
                               {38, -.080f},
                               {44, -.130f},
                               {47, kBustBottom}};
  static constexpr Key kElevation[] = {{0, 50}, {6, 0}, {47, 0}};
  static constexpr Key kZ[] = {{0, kAxisZ}, {29, kAxisZ}, {38, -.045f}, {47, -.050f}};
  return {Lookup(kY, row), Lookup(kElevation, row) * kDegree, Lookup(kZ, row)};
}

Vec GridPosition(int column, int row) {
  const float angle = ColumnAngle(column);
  const float side = SmoothStep(35, 85, std::abs(angle) / kDegree);
  const RowRay f = FrontRay(float(row)), s = SideRay(float(row));
  const Vec origin{0, f.y + side * (s.y - f.y), f.z + side * (s.z - f.z)};
  const float e = f.elevation + side * (s.elevation - f.elevation);
  const Vec direction{std::sin(angle) * std::cos(e), std::sin(e), std::cos(angle) * std::cos(e)};
  Vec p = CastOntoHead(origin, direction);
  if (column == 0 || column == kHalf) p.x = 0;
  return p;
}

class Grid {
 public:
  explicit Grid(MeshBuilder& builder) : builder_(builder), ids_(kColumns * kRows, -1) {
    for (int row = 0; row < kRows; ++row)
      for (int i = 0; i < kColumns; ++i)
        if (!InsideBlock(Signed(i), row))
          Id(i, row) = builder.AddVertex(GridPosition(Signed(i), row), {}, row + 1 < kRows);
    for (int row = 0; row + 1 < kRows; ++row)
      for (int i = 0; i < kColumns; ++i)
        if (!CellInBlock(Signed(i), row))
          builder.AddQuad(
              Id(i, row), Id(i, row + 1), Id(i + 1, row + 1), Id(i + 1, row), i >= kHalf);
  }

  int& Id(int column, int row) { return ids_[size_t(row) * kColumns + Column(column)]; }

  // Counter-clockwise from outside, from the middle of the -x side downwards.
  std::vector<int> Loop(const Block& b) {
    std::vector<int> loop;
    const int middle = (b.row_begin + b.row_end) / 2;
    for (int r = middle; r < b.row_end; ++r) loop.push_back(Id(b.column_begin, r));
    for (int c = b.column_begin; c < b.column_end; ++c) loop.push_back(Id(c, b.row_end));
    for (int r = b.row_end; r > b.row_begin; --r) loop.push_back(Id(b.column_end, r));
    for (int c = b.column_end; c > b.column_begin; --c) loop.push_back(Id(c, b.row_begin));
    for (int r = b.row_begin; r < middle; ++r) loop.push_back(Id(b.column_begin, r));
    return loop;
  }

  // The square patch on the crown whose perimeter is row 0 (a Coons patch of it).
  void AddCap() {
    const int n = kCap;
    std::vector<int> cap((n + 1) * (n + 1));
    auto at = [&](int a, int b) -> int& { return cap[size_t(b) * (n + 1) + a]; };
    for (int k = 0; k <= n; ++k) {  // a grows towards +x, b towards the front
      at(k, n) = Id(k - n / 2, 0);
      at(n, n - k) = Id(n / 2 + k, 0);
      at(n - k, 0) = Id(n / 2 + n + k, 0);
      at(0, k) = Id(n / 2 + 2 * n + k, 0);
    }
    const auto& x = builder_.mesh.positions;
    for (int b = 1; b < n; ++b)
      for (int a = 1; a < n; ++a) {
        const float u = float(a) / n, v = float(b) / n;
        Vec p = (1 - u) * x[at(0, b)] + u * x[at(n, b)] + (1 - v) * x[at(a, 0)] + v * x[at(a, n)] -
                (1 - u) * (1 - v) * x[at(0, 0)] - u * (1 - v) * x[at(n, 0)] -
                (1 - u) * v * x[at(0, n)] - u * v * x[at(n, n)];
        const Vec origin{0, 0.055f, kAxisZ};
        p.y += 0.06f * (1 - std::abs(2 * u - 1)) * (1 - std::abs(2 * v - 1));
        at(a, b) = builder_.AddVertex(CastOntoHead(origin, Normalize(p - origin)), {}, true);
      }
    for (int b = 0; b < n; ++b)
      for (int a = 0; a < n; ++a)
        builder_.AddQuad(at(a, b), at(a, b + 1), at(a + 1, b + 1), at(a + 1, b), a < n / 2);
  }

 private:
  MeshBuilder& builder_;
  std::vector<int> ids_;
};

}  // namespace

HeadMesh MakeHeadMesh() {
  MeshBuilder builder;
  Grid grid(builder);
  grid.AddCap();
  for (int i = 0; i < kColumns; ++i) builder.mesh.neck_loop.push_back(grid.Id(i, kRows - 1));
  AddEye(builder, grid.Loop(kLeftEyeBlock), true);
  AddEye(builder, grid.Loop(kRightEyeBlock), false);
  AddMouth(builder, grid.Loop(kMouthBlock));
  AddEar(builder, grid.Loop(kLeftEarBlock), true);
  AddEar(builder, grid.Loop(kRightEarBlock), false);
  builder.Relax(20);
  AddEyeball(builder, true);
  AddEyeball(builder, false);
  return std::move(builder.mesh);
}

std::vector<Vec> VertexNormals(const std::vector<Vec>& positions,
                               const std::vector<std::array<int32_t, 3>>& faces) {
  std::vector<Vec> normals(positions.size());
  for (const auto& f : faces) {
    const Vec& a = positions[f[0]];
    const Vec area = Cross(positions[f[1]] - a, positions[f[2]] - a);
    for (int v : f) normals[v] += area;
  }
  for (Vec& n : normals) n = Normalize(n);
  return normals;
}

}  // namespace cosplat::procedural
