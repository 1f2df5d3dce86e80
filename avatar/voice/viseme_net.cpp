#include "avatar/voice/viseme_net.h"

#include <Eigen/Core>
#include <cstring>

#include "avatar/voice/voice_net_bytes.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// Numbers of the file, one after another.
class Bytes {
 public:
  Bytes(const unsigned char* begin, size_t size) : bytes_(begin, size) {}

  template <class T>
  T Next() {
    if (bytes_.size() < sizeof(T)) throw Error("the voice's network", "is cut");
    T value;
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return value;
  }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const unsigned char> bytes_;
};

Eigen::ArrayXf Sigmoid(const Eigen::ArrayXf& x) { return (1 + (-x).exp()).inverse(); }

}  // namespace

// The file: magic, the mean of speech, four layers.
struct VisemeNetWeights {
  // y = matrix x + bias. In the file: rows and columns; of each row its scale and its bytes; bias.
  struct Layer {
    Eigen::MatrixXf matrix;
    Eigen::VectorXf bias;

    explicit Layer(Bytes& bytes) {
      const uint32_t rows = bytes.Next<uint32_t>(), columns = bytes.Next<uint32_t>();
      Require(rows <= kMaxSize && columns <= kMaxSize);
      matrix.resize(rows, columns);
      bias.resize(rows);
      for (uint32_t r = 0; r < rows; ++r) {
        const float scale = bytes.Next<float>();
        for (uint32_t c = 0; c < columns; ++c) matrix(r, c) = scale * float(bytes.Next<int8_t>());
      }
      for (float& b : bias) b = bytes.Next<float>();
    }
    Eigen::VectorXf operator()(const Eigen::VectorXf& x) const { return matrix * x + bias; }
  };

  static constexpr uint32_t kMagic = 0x31565343;  // "CSV1"
  static constexpr uint32_t kMaxSize = 4096;

  MelBands mean;
  Layer front, input, recurrent, output;  // rows of the middle two: reset, update, new

  explicit VisemeNetWeights(Bytes bytes)
      : mean(MeanIn(bytes)), front(bytes), input(bytes), recurrent(bytes), output(bytes) {
    const Eigen::Index hidden = recurrent.matrix.cols();
    Require(bytes.empty() && front.matrix.cols() == Eigen::Index(kMelBands) &&
            input.matrix.cols() == front.matrix.rows() && input.matrix.rows() == 3 * hidden &&
            recurrent.matrix.rows() == 3 * hidden && output.matrix.cols() == hidden &&
            output.matrix.rows() == Eigen::Index(kVisemes));
  }

 private:
  static void Require(bool good) {
    if (!good) throw Error("the voice's network", "is of another version");
  }
  static MelBands MeanIn(Bytes& bytes) {
    Require(bytes.Next<uint32_t>() == kMagic);
    MelBands mean;
    for (float& band : mean) band = bytes.Next<float>();
    return mean;
  }
};

const VisemeNetWeights& OwnVisemeNet() {
  static const VisemeNetWeights weights{Bytes(kVoiceNet, kVoiceNetSize)};
  return weights;
}

const MelBands& MeanOfSpeech(const VisemeNetWeights& weights) { return weights.mean; }

VisemeNet::VisemeNet(const VisemeNetWeights& weights)
    : weights_(weights), state_(size_t(weights.recurrent.matrix.cols())) {}

VisemeWeights VisemeNet::Next(const MelBands& mel) {
  Eigen::Map<Eigen::VectorXf> state(state_.data(), Eigen::Index(state_.size()));
  const Eigen::Index n = state.size();
  const Eigen::VectorXf bands = Eigen::Map<const Eigen::VectorXf>(mel.data(), kMelBands);
  const Eigen::VectorXf x = weights_.input(weights_.front(bands).cwiseMax(0.0f));
  const Eigen::VectorXf h = weights_.recurrent(state);
  const Eigen::ArrayXf reset = Sigmoid(x.head(n) + h.head(n));
  const Eigen::ArrayXf update = Sigmoid(x.segment(n, n) + h.segment(n, n));
  const Eigen::ArrayXf next = (x.tail(n).array() + reset * h.tail(n).array()).tanh();
  state = ((1 - update) * next + update * state.array()).matrix();
  Eigen::ArrayXf weights = weights_.output(state).array();
  weights = (weights - weights.maxCoeff()).exp();
  weights /= weights.sum();
  VisemeWeights visemes;
  Eigen::Map<Eigen::ArrayXf>(visemes.data(), kVisemes) = weights;
  return visemes;
}

}  // namespace cosplat
