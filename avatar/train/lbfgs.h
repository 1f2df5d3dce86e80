// Steps of a quasi-Newton method for smooth functions of some hundred numbers.
//
// Ceres, which fits landmarks, has such a method, too, but starts every problem anew. The frames of
// a video are so alike that what one has taught of the second derivative holds for the next: this
// is kept, and halves the steps (docs/tried.md).
#pragma once

#include <deque>
#include <vector>

namespace cosplat {

// The limited-memory BFGS method: the inverse of the second derivative from the last steps and the
// gradient's changes along them. Nocedal & Wright, Numerical Optimization, 2006, algorithm 7.4.
class Lbfgs {
 public:
  // The step to the minimum where the gradient is as given and nonzero. As long as nothing has been
  // learned: against the gradient, by first_length.
  std::vector<double> StepAt(const std::vector<double>& gradient, double first_length) const;
  // gradient_change: over the step. Steps along which the function is not convex teach nothing.
  void Learn(std::vector<double> step, std::vector<double> gradient_change);
  // But for how much the function bends along each number, a mean over many steps.
  void Forget() { pairs_.clear(); }
  bool knows_nothing() const { return pairs_.empty(); }

 private:
  struct Pair {
    std::vector<double> step, gradient_change;
    double product;  // of the two, positive
  };
  // Where the two-loop recursion starts: the numbers differ by far in how much the function bends
  // along them, and a few steps do not tell of each. The last step gives the scale, as ever.
  std::vector<double> InverseDiagonal() const;

  std::deque<Pair> pairs_;       // the oldest first
  std::vector<double> squares_;  // sums over all steps, of the gradient's change per length
};

}  // namespace cosplat
