#include <imgui.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <string>

#include "apps/viewer/screen.h"

namespace cosplat::viewer {
namespace {

constexpr ImGuiWindowFlags kPanelWindow =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings;
constexpr float kHalf = 0.5f;

// A button that takes up this share of the line's width.
bool WideButton(const char* label, float share) {
  const float spacing = ImGui::GetStyle().ItemSpacing.x;
  const float line = ImGui::GetContentRegionMax().x - ImGui::GetWindowContentRegionMin().x;
  return ImGui::Button(label, {share * (line + spacing) - spacing, 0});
}

// "1 234 567".
std::string WithSpaces(size_t number) {
  const std::string digits = std::to_string(number);
  std::string text;
  for (size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ' ';
    text += digits[i];
  }
  return text;
}

void DrawViewPanel(Session& session) {
  if (!ImGui::CollapsingHeader("View", ImGuiTreeNodeFlags_DefaultOpen)) return;
  if (session.IsBeyondFilm()) ImGui::TextUnformatted("Not filmed from here: a guess");
  constexpr const char* kLabels[] = {"Splats", "Ellipsoids", "Triangles by count", "Wire mesh"};
  for (int i = 0; i < kViewCount; ++i) {
    const bool there_is = session.is_avatar() || !NeedsMesh(View(i));
    ImGui::BeginDisabled(!there_is);
    if (i % 2 == 1) ImGui::SameLine(kHalf * ImGui::GetWindowWidth());
    if (ImGui::RadioButton(kLabels[i], session.view() == View(i))) session.SetView(View(i));
    ImGui::EndDisabled();
    if (!there_is && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
      ImGui::SetTooltip("Scenes have no mesh");
  }
  ImGui::BeginDisabled(session.transparent);
  ImGui::ColorEdit3("Background", session.background.data(), ImGuiColorEditFlags_NoInputs);
  ImGui::EndDisabled();
  ImGui::SameLine(kHalf * ImGui::GetWindowWidth());
  ImGui::Checkbox("Transparent", &session.transparent);
  if (WideButton("Reset camera", kHalf)) session.Do(Action::kResetView);
  ImGui::SameLine();
  if (WideButton("Keys (H)", kHalf)) session.Do(Action::kToggleHelp);
}

void DrawSliders(Session& session, std::vector<Slider>& sliders, ScreenResult& result) {
  for (Slider& slider : sliders) {
    ImGui::PushItemWidth(0.56f * ImGui::GetContentRegionAvail().x);
    // A copy, as the sliders may first have to take over the face that is shown.
    float value = slider.value;
    if (ImGui::SliderFloat(slider.name.c_str(),
                           &value,
                           slider.min,
                           slider.max,
                           "%.2f",
                           ImGuiSliderFlags_AlwaysClamp)) {
      session.TakeSliders();
      slider.value = value;
    }
    result.dragging = result.dragging || ImGui::IsItemActive();
    ImGui::PopItemWidth();
  }
}

void DrawDrivers(Session& session) {
  if (!session.has_sequence() && !session.live()) return;
  const auto choice = [&](const char* label, Driver driver) {
    if (ImGui::RadioButton(label, session.driver == driver)) session.driver = driver;
  };
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Driven by");
  if (session.has_sequence()) ImGui::SameLine(), choice("sequence", Driver::kSequence);
  if (session.live()) ImGui::SameLine(), choice("live input", Driver::kLive);
  ImGui::SameLine();
  if (ImGui::RadioButton("sliders", session.driver == Driver::kSliders)) session.TakeSliders();
}

void DrawFacePanel(Session& session, ScreenResult& result) {
  if (!session.is_avatar()) return;
  if (!ImGui::CollapsingHeader("Face", ImGuiTreeNodeFlags_DefaultOpen)) return;
  DrawDrivers(session);
  if (WideButton("Neutral", kHalf)) session.Do(Action::kNeutralFace);
  ImGui::SameLine();
  if (WideButton("Random", kHalf)) session.Do(Action::kRandomFace);
  // While something else drives the face, the sliders only show it.
  if (session.driver != Driver::kSliders) session.face.SetFace(session.Face());
  ImGui::SetNextItemOpen(true, ImGuiCond_Once);
  if (ImGui::TreeNode("Joints (radians)")) {
    DrawSliders(session, session.face.joints(), result);
    ImGui::TreePop();
  }
  ImGui::SetNextItemOpen(true, ImGuiCond_Once);
  if (ImGui::TreeNode("Expressions")) {
    DrawSliders(session, session.face.expressions(), result);
    ImGui::TreePop();
  }
}

// What people have, and what is written for it; the numbers to be completed are the user's.
constexpr struct {
  const char* name;
  const char* drive;
} kDrives[] = {{"This machine's camera", "webcam:"},
               {"This machine's microphone", "audio:"},
               {"VMC: VSeeFace, Warudo, Waidayo", "vmc://0.0.0.0:39539"},
               {"VTube Studio or MeowFace on a phone", "vts://192.168."},
               {"iFacialMocap on a phone", "ifacialmocap://192.168."},
               {"Live Link Face on a phone", "livelink://0.0.0.0"},
               {"Another program, by JSON", "udp://127.0.0.1:9500"}};

void DrawDrivePanel(Session& session, ScreenResult& result) {
  if (!session.open_drive) return;
  if (!ImGui::CollapsingHeader("Drive", ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##kinds", "What moves the face?")) {
    for (const auto& [name, drive] : kDrives)
      if (ImGui::Selectable(name)) session.drive = drive;
    ImGui::EndCombo();
  }
  char text[512] = {};
  session.drive.copy(text, sizeof text - 1);
  ImGui::SetNextItemWidth(kHalf * ImGui::GetWindowWidth());
  const bool entered =
      ImGui::InputText("##drive", text, sizeof text, ImGuiInputTextFlags_EnterReturnsTrue);
  session.drive = text;
  ImGui::SameLine();
  ImGui::BeginDisabled(session.drive.empty() && session.live() == nullptr);
  const bool pressed = ImGui::Button(session.live() ? "Stop (D)" : "Start (D)");
  if (pressed || (entered && !session.live())) result.actions.push_back(Action::kToggleDrive);
  ImGui::EndDisabled();
}

void DrawCount(const char* name, uint64_t count) {
  ImGui::TextUnformatted(name);
  ImGui::SameLine(0.7f * ImGui::GetWindowWidth());
  ImGui::Text("%" PRIu64, count);
}

const char* StateText(FaceState state) {
  switch (state) {
    case FaceState::kRest:
      return "at rest: no frame comes";
    case FaceState::kLive:
      return "live";
    case FaceState::kDecaying:
      return "no frame comes: going to rest";
    case FaceState::kReturning:
      return "frames come again";
  }
  return "";
}

void DrawLivePanel(Session& session) {
  if (!session.live()) return;
  if (!ImGui::CollapsingHeader("Live input", ImGuiTreeNodeFlags_DefaultOpen)) return;
  const LiveFace& live = *session.live();
  ImGui::TextWrapped("%s", live.Description().c_str());
  ImGui::Text("The face is %s%s", StateText(live.guard().state()), live.Ended() ? "; ended" : "");
  ImGui::Text("%.0f frames per second", live.frames_per_second());
  if (WideButton("I look straight ahead", 1)) session.Do(Action::kCalibrate);
  const LiveCounts sent = live.Counts();
  const GuardCounts& shown = live.guard().counts();
  DrawCount("packets", sent.packets);
  DrawCount("of them of no use here", sent.unusable);
  DrawCount("frames shown", shown.accepted);
  DrawCount("replaced by newer ones", sent.replaced + shown.replaced);
  DrawCount("late, out of order", sent.reordered + shown.late);
  DrawCount("malformed", sent.malformed + shown.not_finite + shown.wrong_size);
  DrawCount("beyond any face", shown.out_of_range);
  DrawCount("too long", sent.oversize);
  DrawCount("too many at once", sent.flooded);
  DrawCount("brought back into range", shown.softened);
  if (!sent.last_problem.empty()) ImGui::TextWrapped("Last: %s", sent.last_problem.c_str());
  if (const std::string notes = NotesOf(sent); !notes.empty())
    ImGui::TextWrapped("Not used: %s", notes.c_str());
}

void DrawGraph(const char* name, const TimeHistory& history, float scale) {
  const std::vector<float> values = history.Values();
  const float max = values.empty() ? 1 : *std::max_element(values.begin(), values.end());
  const float last = values.empty() ? 0 : values.back();
  ImGui::Text("%s %.1f ms, median %.1f", name, double(last), double(history.Median()));
  ImGui::PushID(name);
  ImGui::PlotLines("",
                   values.data(),
                   int(values.size()),
                   0,
                   nullptr,
                   0,
                   1.15f * max,
                   {ImGui::GetContentRegionAvail().x, 44 * scale});
  ImGui::PopID();
}

void DrawTimesPanel(const ScreenState& state) {
  if (!ImGui::CollapsingHeader("Times", ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::Text("%d x %d pixels%s",
              state.width,
              state.height,
              state.divisor > 1 ? ", reduced while dragging" : "");
  DrawGraph("drawing", state.drawing, state.scale);
  DrawGraph("latency", state.latency, state.scale);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("From the hand, or the frame's own time, to the screen");
}

void DrawCapturePanel(const ScreenState& state, ScreenResult& result) {
  const bool recording = state.recorded_seconds >= 0;
  if (WideButton("Screenshot (S)", kHalf)) result.actions.push_back(Action::kScreenshot);
  ImGui::SameLine();
  if (WideButton(recording ? "Stop video (V)" : "Record video (V)", kHalf))
    result.actions.push_back(Action::kToggleRecording);
}

}  // namespace

void DrawPanels(Session& session,
                const ScreenState& state,
                ScreenRect place,
                ScreenResult& result) {
  ImGui::SetNextWindowPos({place.x, place.y});
  ImGui::SetNextWindowSize({place.width, place.height});
  ImGui::Begin("panels", nullptr, kPanelWindow & ~ImGuiWindowFlags_NoScrollbar);
  ImGui::TextUnformatted(session.title().c_str());
  ImGui::TextDisabled("%s, %s Gaussians",
                      session.is_avatar() ? "Avatar" : "Scene",
                      WithSpaces(session.gaussian_count()).c_str());
  DrawCapturePanel(state, result);
  DrawViewPanel(session);
  DrawTimesPanel(state);
  DrawDrivePanel(session, result);
  DrawLivePanel(session);
  DrawFacePanel(session, result);
  ImGui::End();
}

void DrawTimeline(Session& session, ScreenRect place) {
  ImGui::SetNextWindowPos({place.x, place.y});
  ImGui::SetNextWindowSize({place.width, place.height});
  ImGui::Begin("timeline", nullptr, kPanelWindow);
  Timeline& timeline = session.timeline;
  const float letters = ImGui::GetFontSize();
  const bool plays = timeline.playing() && session.driver == Driver::kSequence;
  if (ImGui::Button(plays ? "Pause" : "Play", {4.2f * letters, 0})) {
    if (session.driver == Driver::kSequence) {
      timeline.Toggle();
    } else {
      session.driver = Driver::kSequence;
      timeline.Play();
    }
  }
  ImGui::SameLine();
  ImGui::Checkbox("Loop", &timeline.loops);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(7 * letters);
  ImGui::SliderFloat("##speed",
                     &timeline.speed,
                     0.1f,
                     4,
                     "speed %.2f",
                     ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
  ImGui::SameLine();
  char text[48];
  std::snprintf(text, sizeof text, "%%d of %d   %.1f s", timeline.frames() - 1, timeline.seconds());
  int frame = timeline.frame();
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderInt("##frame", &frame, 0, timeline.frames() - 1, text)) {
    session.driver = Driver::kSequence;
    timeline.Seek(frame);
  }
  ImGui::End();
}

}  // namespace cosplat::viewer
