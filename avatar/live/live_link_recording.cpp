#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <optional>

#include "avatar/live/score_recording.h"
#include "avatar/live/unused_input.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Rates of timecodes. The app's own is 60; those of devices that it follows are lower.
constexpr int kRates[] = {15, 24, 25, 30, 48, 50, 60};
constexpr double kDaySeconds = 24 * 3600;
constexpr int kWrittenRate = 60;

// The table's names of a head's angles; the first two grow the other way than ours.
constexpr const char* kAngleNames[] = {"HeadPitch", "HeadYaw", "HeadRoll"};

std::vector<std::string_view> CellsOf(std::string_view line) {
  std::vector<std::string_view> cells;
  if (line.ends_with('\r')) line.remove_suffix(1);
  for (size_t end; (end = line.find(',')) != line.npos; line.remove_prefix(end + 1))
    cells.push_back(line.substr(0, end));
  cells.push_back(line);
  return cells;
}

std::optional<double> FiniteNumber(std::string_view text) {
  const std::optional<double> number = NumberOf<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// "10:31:05:17.250": hours, minutes, seconds and frames.
struct Timecode {
  double seconds = 0, frame = 0;
};

std::optional<Timecode> TimecodeOf(std::string_view text) {
  double parts[4];
  for (double& part : parts) {
    const size_t end = std::min(text.find(':'), text.size());
    const std::optional<double> number = FiniteNumber(text.substr(0, end));
    if (!number || *number < 0 || *number >= kRates[std::size(kRates) - 1]) return {};
    part = *number;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (!text.empty() || parts[0] >= 24) return {};
  return Timecode{(parts[0] * 60 + parts[1]) * 60 + parts[2], parts[3]};
}

struct Row {
  Timecode time;
  ScoredFrame frame;
};

std::string ColumnName(std::string_view arkit) {
  std::string name(arkit);
  name[0] = char(name[0] - 'a' + 'A');
  return name;
}

class Table {
 public:
  explicit Table(const std::string& path) : path_(path), file_(path) {
    if (!file_) throw Error(path, "cannot be read");
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    std::string line;
    std::getline(file_, line);
    std::string_view header = line;
    if (header.starts_with(kByteOrderMark)) header.remove_prefix(kByteOrderMark.size());
    for (const std::string_view cell : CellsOf(header)) names_.emplace_back(cell);
    time_ = Column("Timecode");
    count_ = Column("BlendShapeCount");
    for (size_t axis = 0; axis < 3; ++axis) angles_[axis] = Column(kAngleNames[axis]);
  }

  // Returns false at the end of the file.
  bool Next(std::optional<Row>& row) {
    std::string line;
    row.reset();
    ++number_;
    if (!std::getline(file_, line)) return false;
    const std::vector<std::string_view> cells = CellsOf(line);
    if (cells.size() <= count_ || cells[count_] == "0") return true;
    if (cells.size() != names_.size())
      throw Error(
          path_, Where(""), Format("has {} cells, expected {}", cells.size(), names_.size()));
    row = RowOf(cells);
    return true;
  }

  // Of the row that Next read last.
  [[noreturn]] void Fail(size_t column, std::string_view found, const char* expected) const {
    throw Error(path_,
                Where(names_[column]),
                Format("found '{}', expected {}", PrintableName(found), expected));
  }
  size_t time() const { return time_; }

  // "has no column JawOpen, MouthClose": of the 52 names, but for the tongue, which old phones
  // lack. Throws Error if it has none of them.
  std::vector<std::string> LackingColumns() const {
    std::string lacking;
    size_t count = 0;
    for (const std::string_view arkit : kArkitNames) {
      const std::string name = ColumnName(arkit);
      if (std::find(names_.begin(), names_.end(), name) != names_.end() || name == "TongueOut")
        continue;
      if (++count <= 4) lacking += (lacking.empty() ? "" : ", ") + name;
    }
    if (count + 1 >= std::size(kArkitNames))
      throw Error(path_, "has no blendshape's column, such as JawOpen");
    if (lacking.empty()) return {};
    return {Format("has no column {}{}", lacking, count > 4 ? ", ..." : "")};
  }

 private:
  size_t Column(const char* name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end())
      throw Error(path_, name, "is no column: this is no recording of Live Link Face");
    return size_t(found - names_.begin());
  }

  std::string Where(const std::string& column) const {
    return Format("line {}", number_) + (column.empty() ? "" : ", " + column);
  }

  Row RowOf(const std::vector<std::string_view>& cells) const {
    Row row;
    const std::optional<Timecode> time = TimecodeOf(cells[time_]);
    if (!time) Fail(time_, cells[time_], "hours:minutes:seconds:frames, up to 60 frames");
    row.time = *time;
    for (size_t i = 0; i < cells.size(); ++i) {
      const int place = FindArkitBlendshape(names_[i]);
      if (place < 0) continue;
      const std::optional<double> score = FiniteNumber(cells[i]);
      if (!score || std::abs(*score) > double(kMaxScore)) Fail(i, cells[i], "a score from 0 to 1");
      row.frame.scores[std::string(kArkitNames[size_t(place)])] = float(*score);
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t i = angles_[axis];
      const std::optional<double> angle = FiniteNumber(cells[i]);
      constexpr double kMaxTurn = 100 * kDegree;  // no camera sees a face that is turned further
      if (!angle || std::abs(*angle) > kMaxTurn) Fail(i, cells[i], "an angle in radians");
      // Pitch looks up, yaw turns right, roll leans to the right shoulder.
      row.frame.head[axis] = float(axis < 2 ? -*angle : *angle);
    }
    return row;
  }

  std::string path_;
  std::ifstream file_;
  std::vector<std::string> names_;
  size_t time_ = 0, count_ = 0;
  std::array<size_t, 3> angles_{};  // pitch, yaw, roll
  int number_ = 1;                  // of the line
};

// The frames per second that the timecodes count, which the file does not say: the lowest rate
// above every frame's number, once a whole second has passed.
int RateOf(const std::vector<Row>& rows) {
  double most = 0;
  for (const Row& row : rows) most = std::max(most, row.time.frame);
  const bool whole = rows.back().time.seconds > rows.front().time.seconds + 1;
  for (const int rate : kRates)
    if (whole && most < rate) return rate;
  return kRates[std::size(kRates) - 1];
}

// What is unusual about times and heads.
void AddNotes(ScoreRecording& recording) {
  constexpr double kLongSeconds = 10;
  constexpr float kFarTurned = float(60 * kDegree);  // a camera loses such a face
  double longest = 0;
  float turned = 0;
  int64_t before = 0;
  for (const ScoredFrame& frame : recording.frames) {
    longest = std::max(longest, double(frame.timestep - before) / recording.frames_per_second);
    before = frame.timestep;
    for (const float angle : frame.head) turned = std::max(turned, std::abs(angle));
  }
  if (longest > kLongSeconds)
    recording.notes.push_back(Format("has no face for {:.0f} s: the last one is held", longest));
  if (turned > kFarTurned)
    recording.notes.push_back(
        Format("turns the head by {:.0f} degrees: are its angles in radians?", turned / kDegree));
}

}  // namespace

ScoreRecording LoadLiveLinkRecording(const std::string& path) {
  Table table(path);
  std::vector<Row> rows;
  size_t without = 0;
  for (std::optional<Row> row; table.Next(row);) {
    if (!row) {
      ++without;
      continue;
    }
    if (!rows.empty()) {
      // Over midnight, or set back.
      double& seconds = row->time.seconds;
      const Timecode& last = rows.back().time;
      if (seconds + kDaySeconds / 2 < last.seconds) seconds += kDaySeconds;
      if (seconds < last.seconds || (seconds == last.seconds && row->time.frame < last.frame))
        table.Fail(table.time(), "an earlier one", "a time after that of the line before");
    }
    rows.push_back(std::move(*row));
  }
  if (rows.empty()) throw Error(path, "no row has scores: the app saw no face");
  const int rate = RateOf(rows);
  ScoreRecording recording;
  recording.notes = table.LackingColumns();
  if (without > 0)
    recording.notes.push_back(Format("{} of {} rows have no face", without, rows.size() + without));
  int64_t step = 0;
  const auto time_of = [&](const Row& row) {
    return std::llround(row.time.seconds * rate + row.time.frame);
  };
  for (Row& row : rows) {
    row.frame.timestep = time_of(row) - time_of(rows.front());
    auto& frames = recording.frames;
    if (!frames.empty() && frames.back().timestep == row.frame.timestep) frames.pop_back();
    if (!frames.empty()) step = std::gcd(step, row.frame.timestep);
    frames.push_back(std::move(row.frame));
  }
  if (8 * recording.frames.size() < rows.size())
    throw Error(path,
                "Timecode",
                Format("has {} times for {} rows: the recording has no clock",
                       recording.frames.size(),
                       rows.size()));
  // Of a phone that records every other frame.
  step = std::max<int64_t>(step, 1);
  if (rate % step != 0) step = 1;
  for (ScoredFrame& frame : recording.frames) frame.timestep /= step;
  recording.frames_per_second = double(rate) / double(step);
  AddNotes(recording);
  return recording;
}

void WriteLiveLinkRecording(const ScoreRecording& recording, const std::string& path) {
  const double rate = recording.frames_per_second;
  if (!(rate > 0 && rate <= kWrittenRate))
    throw Error(path, Format("{} frames per second", rate), "do not fit into timecodes of 60");
  std::string table = "Timecode,BlendShapeCount";
  for (const std::string_view name : kArkitNames) table.append(",").append(ColumnName(name));
  for (const char* name : kAngleNames) table.append(",").append(name);
  for (const ScoredFrame& frame : recording.frames) {
    // Thousandths of a frame of the app's own rate, which no reader takes for another.
    const int64_t time = std::llround(double(frame.timestep) * 1000 * kWrittenRate / rate);
    const int64_t seconds = time / (1000 * kWrittenRate), left = time % (1000 * kWrittenRate);
    table += Format("\n{:02d}:{:02d}:{:02d}:{:02d}.{:03d},{}",
                    seconds / 3600,
                    seconds / 60 % 60,
                    seconds % 60,
                    left / 1000,
                    left % 1000,
                    kArkitBlendshapes + std::size(kAngleNames));
    for (const std::string_view name : kArkitNames) {
      const auto score = frame.scores.find(std::string(name));
      table += Format(",{:.6f}", score == frame.scores.end() ? 0.0f : score->second);
    }
    for (size_t axis = 0; axis < 3; ++axis)
      table += Format(",{:.6f}", axis < 2 ? -frame.head[axis] : frame.head[axis]);
  }
  WriteFileAtomically(path, table + "\n");
}

}  // namespace cosplat
