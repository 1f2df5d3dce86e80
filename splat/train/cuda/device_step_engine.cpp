#include "splat/train/cuda/device_step_engine.h"

#include <algorithm>

#include "splat/base/error.h"
#include "splat/train/cuda/device_memory.h"
#include "splat/train/loss.h"

namespace cosplat::cuda {
namespace {

constexpr double kTargetShare = 0.25;  // of the memory that is free at first

void CheckRule(PruneRule rule) {
  if (WorksOnProcessorOnly(rule))
    throw Error("--prune " + ToString(rule),
                "works in every step on the processor: give --device cpu, or another rule");
}

}  // namespace

DeviceStepEngine::DeviceStepEngine(const TrainSettings& settings,
                                   Subject& subject,
                                   TrainingState& state,
                                   SumOrder order,
                                   std::shared_ptr<DeviceSubject> on_device,
                                   const InstanceForecast& forecast)
    : settings_(settings),
      subject_(subject),
      state_(state),
      on_device_(on_device ? std::move(on_device) : std::make_shared<DeviceSubject>()),
      order_(order),
      renderer_(order),
      targets_(subject, size_t(kTargetShare * double(FreeMemory()))),
      density_(*on_device_, SpareCanvas()),
      forecast_(forecast) {
  CheckRule(settings.prune.rule);
  Store();
}

StepEngineMaker MakeDeviceStepEngine(SumOrder order,
                                     std::shared_ptr<DeviceSubject> on_device,
                                     const InstanceForecast& forecast) {
  return [=](const TrainSettings& settings, Subject& subject, TrainingState& state) {
    return std::make_unique<DeviceStepEngine>(settings, subject, state, order, on_device, forecast);
  };
}

void DeviceStepEngine::CatchUp(const AdamSettings& rates) {
  Settle(0);
  population_.adam.CatchUpAll(
      rates, on_device_->PositionRateScale(stream()), population_.values, stream());
  fetched_ = false;
}

void DeviceStepEngine::AfterStep(int iteration) {
  if (!on_device_->WorksAfter(iteration)) return;
  Settle(0);
  on_device_->Work(population_, stream());
  fetched_ = false;
}

size_t DeviceStepEngine::MostThatFit() const {
  Footprint footprint = FootprintOf(population_.values, order_, instances_per_gaussian_);
  footprint.per_gaussian += double(on_device_->BytesPerGaussian());
  size_t held = density_.held();
  for (const MemoryPart& part : Memory())
    if (part.of == MemoryOf::kGaussians) held += part.bytes;
  return footprint.MostThatFit(held, FreeMemory());
}

void DeviceStepEngine::ControlDensity(const DensitySettings& settings, bool remove_oversized) {
  DensitySettings limited = settings;
  limited.max_count = std::min(settings.max_count, MostThatFit());
  const bool held_back =
      density_.Control(limited, remove_oversized, population_, state_.rng, stream());
  fetched_ = false;
  instances_per_gaussian_ = 0;
  if (!held_back || limited.max_count == settings.max_count || told_of_memory_) return;
  told_of_memory_ = true;
  notice_ = NoticeOfMemory(count());
}

void DeviceStepEngine::Prune(const PruneRound& round, int group_cap, int group_floor) {
  StoreMask();  // ranking may have begun or ended it
  const std::vector<uint8_t> unwanted =
      UnwantedBy(round,
                 count(),
                 on_device_->Groups(stream()),
                 group_cap,
                 group_floor,
                 [this](std::vector<uint8_t>& marks) { HeedVeto(marks); });
  unwanted_.Upload(unwanted.data(), unwanted.size(), stream());
  density_.Take(std::as_const(unwanted_).view(), population_, stream());
  fetched_ = false;
}

void DeviceStepEngine::HeedVeto(std::vector<uint8_t>& unwanted) {
  unwanted_.Upload(unwanted.data(), unwanted.size(), stream());
  on_device_->Veto(population_.values, SpareCanvas(), unwanted_.view());
  unwanted_.Download(unwanted.data(), stream());
  renderer_.stream().Wait();
}

void DeviceStepEngine::SortInSpace() {
  density_.SortInSpace(population_, stream());
  fetched_ = false;
}

void DeviceStepEngine::ResetStatistics() {
  population_.statistics.Reset(count(), stream());
  fetched_ = false;
}

void DeviceStepEngine::ResetOpacity() {
  cuda::ResetOpacity(population_, stream());
  fetched_ = false;
}

void DeviceStepEngine::Fetch() {
  if (fetched_) return;
  Settle(0);
  population_.Download(state_, stream());
  population_.mask.Download(stream());
  on_device_->Fetch(stream());
  fetched_ = true;
}

void DeviceStepEngine::FetchForRanking() {
  population_.DownloadForRanking(state_, stream());
  population_.mask.Download(stream());
}

void DeviceStepEngine::SetPruner(Pruner* pruner) {
  pruner_ = pruner;
  StoreMask();
}

void DeviceStepEngine::StoreMask() {
  population_.mask.Upload(pruner_ ? pruner_->Mask() : MaskInSteps(), stream());
}

void DeviceStepEngine::Store() {
  population_.Upload(state_, stream());
  StoreMask();
  on_device_->Store(stream());
  renderer_.stream().Wait();  // for the state's memory
  in_flight_ = 0;             // steps of another state
  fetched_ = true;
}

std::vector<Contribution> DeviceStepEngine::Contributions(const FrameChoice& choice) {
  contributions_.Refill(count());
  contributions_.FillWithZeros(stream());
  for (size_t k = 0; k < choice.count(); ++k) {
    renderer_.Forward(on_device_->Place(population_.values, choice[k], stream()),
                      state_.gaussians.basis,
                      subject_.frame(choice[k]).camera,
                      {choice.background, choice.degree},
                      true,
                      image_,
                      tape_);
    renderer_.Contributions(image_, tape_, of_picture_);
    AddContributions(std::as_const(of_picture_).view(), contributions_.view(), stream());
  }
  std::vector<Contribution> sums(count());
  contributions_.Download(sums.data(), stream());
  renderer_.stream().Wait();
  return sums;
}

double DeviceStepEngine::MeanPsnr(const FrameChoice& choice) {
  Buffer<float> picture, target;
  double sum = 0;
  for (size_t k = 0; k < choice.count(); ++k) {
    const TrainFrame& frame = subject_.frame(choice[k]);
    renderer_.Forward(on_device_->Place(population_.values, choice[k], stream()),
                      state_.gaussians.basis,
                      frame.camera,
                      {choice.background, choice.degree},
                      false,
                      image_,
                      tape_);
    picture.resize(image_.color.size());
    image_.color.Download(picture.data(), stream());
    renderer_.stream().Wait();
    for (float& c : picture) c = std::clamp(c, 0.0f, 1.0f);
    CompositeTarget(frame.target, choice.background, target);
    sum += Psnr(picture, target);
  }
  return choice.count() == 0 ? 0 : sum / double(choice.count());
}

std::vector<MemoryPart> DeviceStepEngine::Memory() const {
  std::vector<MemoryPart> parts = population_.Memory();
  for (MemoryPart& part : on_device_->Memory()) parts.push_back(std::move(part));
  for (MemoryPart& part : tape_.Memory()) parts.push_back(std::move(part));
  parts.push_back({"screen gradients", HeldBy(screen_)});
  parts.push_back({"picture and its gradient",
                   HeldBy(image_.color, image_.transmittance, d_color_),
                   MemoryOf::kPixels});
  parts.push_back({"photographs", targets_.held(), MemoryOf::kPixels});
  return parts;
}

}  // namespace cosplat::cuda
