// The stability cases of the colour basis.
#include <array>
#include <cmath>

#include "apps/study/stability/basis_forms.h"
#include "apps/study/stability/cases.h"
#include "apps/study/stability/image.h"
#include "apps/study/stability/naive_basis.h"
#include "splat/base/rng.h"
#include "splat/basis_constants.h"
#include "splat/math/dcsh.h"

namespace cosplat {
namespace {

constexpr int kDegree = 3, kFunctions = CoefficientCount(kDegree);
using Vec3 = math::Vec3<float>;
using Basis16 = std::array<float, kFunctions>;

const float* Constants() { return BasisConstants(Basis::kDcsh); }

Vec3 Rounded(const ExactDirection& d) { return {float(d.x), float(d.y), float(d.z)}; }

Basis16 LiteralAt(const Vec3& u) {
  Basis16 basis;
  math::BasisAtAngles<kDegree>(math::LiteralAngles(u), Constants(), basis.data());
  return basis;
}
Basis16 TextbookAt(const Vec3& u) {
  Basis16 basis;
  math::BasisAtAngles<kDegree>(math::TextbookAngles(u), Constants(), basis.data());
  return basis;
}
Basis16 OursAt(const Vec3& u) {
  Basis16 basis;
  math::EvaluateBasis<kDegree>(u, Constants(), basis.data());
  return basis;
}

// Coefficients of a random Gaussian.
struct Coefficients {
  float dc[3], rest[3 * (kFunctions - 1)];

  explicit Coefficients(uint64_t seed) {
    Rng rng{seed};
    for (float& c : dc) c = 0.4f * rng.Normal();
    for (float& c : rest) c = 0.08f * rng.Normal();
  }
  Vec3 Literal(const Vec3& u) const {
    return math::ColorOfBasis<kDegree>(LiteralAt(u).data(), dc, rest);
  }
  Vec3 Ours(const Vec3& u) const {
    return math::EvaluateColor<kDegree, float>(u, Constants(), dc, rest);
  }
};
constexpr uint64_t kSeed = 4;

// A ball of radius 1 seen from far away, from a side that shows the pole and the plane u_x = 0.
template <class F>
Image8 Ball(const F& color) {
  constexpr int kSide = 176;
  const Vec3 toward = math::Normalize(Vec3{0.45f, -0.6f, 0.7f});
  const Vec3 right = math::Normalize(math::Cross(Vec3{0, 0, 1}, toward));
  const Vec3 up = math::Cross(toward, right);
  return Paint(kSide, kSide, [&](int px, int py) {
    const float x = (px + 0.5f) / (0.5f * kSide) - 1, y = 1 - (py + 0.5f) / (0.5f * kSide);
    const float square = x * x + y * y;
    if (square > 0.98f) return Vec3{1, 1, 1};
    return color(math::Normalize(right * x + up * y + toward * std::sqrt(1 - square)));
  });
}

template <class T>
double LargestDifference(const math::Vec3<T>& a, const math::Vec3<T>& b) {
  const math::Vec3<T> d = a - b;
  return LargerError(double(std::abs(d.x)),
                     LargerError(double(std::abs(d.y)), double(std::abs(d.z))));
}

// Over steps of 1e-6 rad around the sphere's axis, at all heights, across u_x = 0 and elsewhere.
template <class F>
double LargestJump(const F& color) {
  constexpr double kStep = 1e-6;
  double largest = 0;
  for (int i = 1; i < 60; ++i)
    for (int k = 0; k < 16; ++k) {
      const double polar = M_PI * i / 60, turn = M_PI * k / 8;
      largest =
          LargerError(largest,
                      LargestDifference(color(Rounded(DirectionAt(polar, turn - kStep / 2))),
                                        color(Rounded(DirectionAt(polar, turn + kStep / 2)))));
    }
  return largest;
}

int CountNotFinite(const Basis16& basis) {
  int count = 0;
  for (const float b : basis) count += !std::isfinite(b);
  return count;
}

// Directions around the pole; a pixel is 2e-8 rad, and the middle one is the pole itself.
template <class F>
Image8 AroundThePole(const F& color) {
  constexpr int kCells = 21, kCell = 8;
  return Paint(kCells * kCell, kCells * kCell, [&](int px, int py) {
    constexpr float kRad = 2e-8f;
    const float x = kRad * float(px / kCell - kCells / 2),
                y = kRad * float(kCells / 2 - py / kCell);
    return color(Vec3{x, y, 1});
  });
}

constexpr double kFirstPolar = 1e-7, kPerPolar = 1.25892541;  // a tenth of a decade
constexpr int kPolars = 71, kTurns = 24;

// Maximum of measure(direction) over the azimuths, at angles from the pole up to 1 rad.
template <class F>
StabilityCurve CurveFromPole(const std::string& name, const F& measure) {
  StabilityCurve curve{name, {}};
  double polar = kFirstPolar;
  for (int i = 0; i < kPolars; ++i, polar *= kPerPolar) {
    double largest = 0;
    for (int k = 0; k < kTurns; ++k)
      largest = LargerError(largest, measure(DirectionAt(polar, 2 * M_PI * (k + 0.5) / kTurns)));
    curve.points.push_back({polar, largest});
  }
  return curve;
}
double Largest(const StabilityCurve& curve) {
  double largest = 0;
  for (const auto& point : curve.points) largest = std::max(largest, point[1]);
  return largest;
}

double BasisError(const ExactDirection& direction, const Basis16& basis) {
  const ExactBasis exact = ExactBasisAt(direction);
  double largest = 0;
  for (int k = 0; k < kFunctions; ++k)
    largest = LargerError(largest, double(std::abs(basis[k] - exact[k])));
  return largest;
}

// Tangential part of the gradient. The radial part has no effect on what follows (NormalizeVjp).
template <class T>
math::Vec3<T> Tangential(const math::Vec3<T>& u, const math::Vec3<T>& d) {
  return d - u * math::Dot(u, d);
}
template <class T, class F>
math::Vec3<T> GradientOfSum(const math::Vec3<T>& u, const F& vjp) {
  T weights[kFunctions];
  for (int k = 0; k < kFunctions; ++k) weights[k] = T(k % 2 ? -1 : 1);
  return Tangential(u, vjp(u, weights));
}
template <class F>
double GradientError(const ExactDirection& d, const F& vjp) {
  using Exact = math::Vec3<long double>;
  const Exact exact = GradientOfSum(Exact{d.x, d.y, d.z}, [](const auto& u, const auto* w) {
    return math::EvaluateBasisVjp<kDegree>(u, Constants(), w);
  });
  const Vec3 g = GradientOfSum(Rounded(d), vjp);
  return LargestDifference(Exact{g.x, g.y, g.z}, exact);
}

}  // namespace

StabilityCase ArctanJump() {
  const Coefficients c(kSeed);
  const auto literal = [&](const Vec3& u) { return c.Literal(u); };
  const auto ours = [&](const Vec3& u) { return c.Ours(u); };
  StabilityCase s;
  s.key = "arctan_jump";
  s.title = "The arctangent's jump at u_x = 0";
  s.what =
      "arctan(u_y / u_x) does not know on which side of the plane u_x = 0 it is: functions of odd "
      "m have the wrong sign behind it and jump across it. A ball in a random colour of degree 3.";
  s.quantity = "largest change of the colour over 1e-6 rad";
  s.naive = {"arctan, as DCSHARP writes it", LargestJump(literal), Ball(literal)};
  s.ours = {"polynomials", LargestJump(ours), Ball(ours)};
  s.bound = 1e-5;  // the colour's steepest slope, below 5 per rad, plus rounding
  return s;
}

StabilityCase ThePole() {
  const Coefficients c(kSeed);
  StabilityCase s;
  s.key = "pole";
  s.title = "0 / 0 at the pole";
  s.what =
      "Straight up and straight down, u_y / u_x is 0 / 0. The image shows directions a hundred "
      "millionth of a radian apart around the pole; magenta is not a number.";
  s.quantity = "basis functions of 32 that are not a number at the two poles";
  const Vec3 up{0, 0, 1}, down{0, 0, -1};
  s.naive = {"arctan, as DCSHARP writes it",
             double(CountNotFinite(LiteralAt(up)) + CountNotFinite(LiteralAt(down))),
             AroundThePole([&](const Vec3& u) { return c.Literal(u); })};
  s.ours = {"polynomials",
            double(CountNotFinite(OursAt(up)) + CountNotFinite(OursAt(down))),
            AroundThePole([&](const Vec3& u) { return c.Ours(u); })};
  s.bound = 0;
  return s;
}

StabilityCase AnglesInFloat() {
  StabilityCase s;
  s.key = "angles_in_float";
  s.title = "Angles in single precision";
  s.what =
      "acos is flat to a float near the poles: the direction's angle from the pole is lost below "
      "3e-4 rad. Degree 3, against long double.";
  s.quantity = "largest error of a basis function";
  const StabilityCurve naive = CurveFromPole(
      "acos, atan2", [](const ExactDirection& d) { return BasisError(d, TextbookAt(Rounded(d))); });
  const StabilityCurve ours = CurveFromPole(
      "polynomials", [](const ExactDirection& d) { return BasisError(d, OursAt(Rounded(d))); });
  s.naive = {"acos and atan2, as in textbooks", Largest(naive), {}};
  s.ours = {"polynomials", Largest(ours), {}};
  s.bound = 3e-6;  // a dozen rounding errors of functions up to 4
  s.chart = {"angle from the pole", "rad", "largest error", "", true, true, {naive, ours}};
  return s;
}

StabilityCase GradientOfAngles() {
  StabilityCase s;
  s.key = "gradient_of_angles";
  s.title = "The gradient through angles";
  s.what =
      "The chain rule through angles divides by the distance from the pole, twice. Gradient of the "
      "alternating sum of degree 3's functions along the sphere, against long double.";
  s.quantity = "largest error of the gradient";
  const StabilityCurve naive = CurveFromPole("acos, atan2", [](const ExactDirection& d) {
    return GradientError(d, [](const Vec3& u, const float* w) {
      return math::TextbookBasisVjp<kDegree>(u, Constants(), w);
    });
  });
  const StabilityCurve ours = CurveFromPole("polynomials", [](const ExactDirection& d) {
    return GradientError(d, [](const Vec3& u, const float* w) {
      return math::EvaluateBasisVjp<kDegree>(u, Constants(), w);
    });
  });
  s.naive = {"chain rule through acos and atan2", Largest(naive), {}};
  s.ours = {"polynomials", Largest(ours), {}};
  s.bound = 3e-5;
  s.chart = {"angle from the pole", "rad", "largest error", "", true, true, {naive, ours}};
  return s;
}

StabilityCase FormsOverTheSphere() {
  StabilityCase s;
  s.key = "forms_over_the_sphere";
  s.title = "Error of the forms over the whole sphere";
  s.what =
      "Colours of degrees 0 to 6 with random coefficients, in directions all over the sphere and "
      "close to its poles, against long double. The times are in the chart above.";
  s.quantity = "largest error of a colour, degree 6";
  const std::vector<BasisForm> forms = MeasureBasisForms(0);
  s.chart = {"degree", "", "largest error", "", false, true, {}};
  for (const BasisForm& form : forms) {
    StabilityCurve curve{form.name, {}};
    for (const BasisFormPoint& point : form.points)
      curve.points.push_back({double(point.degree), point.error});
    s.chart.curves.push_back(curve);
    const double last = form.points.back().error;
    if (form.name == "acos, atan2, float") s.naive = {"acos and atan2, float", last, {}};
    if (form.name == "polynomials, SIMD") s.ours = {"polynomials, SIMD", last, {}};
  }
  s.bound = 5e-6;
  return s;
}

}  // namespace cosplat
