#include "generate/train/training_run.h"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <numbers>

#include "capture/errors.h"
#include "replay/atomic_file.h"
#include "replay/picture/canvas.h"
#include "replay/picture/plot.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

/// One line of the figures: step, loss since the last one, measurements.
struct Line {
  std::int64_t step = 0;
  double loss = 0;
  Measurements measured;
};

class Checkpoint {
 public:
  Checkpoint(const TrainingOptions& options) : path_(options.folder / (options.name + ".checkpoint")) {
    identity_ = fmt::format("{} steps, seed {}, rate {}, decay {}, {}", options.steps, options.seed,
                            options.learning_rate, options.weight_decay, options.what);
  }

  void save(torch::nn::Module& network, torch::optim::Optimizer& optimizer, const std::vector<Line>& lines) const {
    torch::serialize::OutputArchive archive, weights, moments;
    network.save(weights);
    optimizer.save(moments);
    archive.write("identity", c10::IValue(identity_));
    archive.write("network", weights);
    archive.write("optimizer", moments);
    std::vector<double> numbers;
    std::vector<std::string> names;
    for (const Line& line : lines) {
      numbers.push_back(static_cast<double>(line.step));
      numbers.push_back(line.loss);
      for (const auto& [name, value] : line.measured) numbers.push_back(value);
    }
    if (!lines.empty())
      for (const auto& [name, value] : lines.front().measured) names.push_back(name);
    archive.write("lines", torch::tensor(numbers, torch::kFloat64));
    archive.write("names", c10::IValue(fmt::format("{}", fmt::join(names, "\n"))));
    const std::filesystem::path partial = path_.string() + ".partial";
    archive.save_to(partial.string());
    std::filesystem::rename(partial, path_);
  }

  /// False if there is none.
  bool load(torch::nn::Module& network, torch::optim::Optimizer& optimizer, std::vector<Line>& lines) const {
    if (!std::filesystem::exists(path_)) return false;
    torch::serialize::InputArchive archive, weights, moments;
    archive.load_from(path_.string());
    c10::IValue identity, names;
    archive.read("identity", identity);
    if (identity.toStringRef() != identity_)
      throw UserError(path_.string(), "is of another training (" + identity.toStringRef() + ")",
                      "delete it, or train into another folder (--out)");
    archive.read("network", weights);
    archive.read("optimizer", moments);
    network.load(weights);
    optimizer.load(moments);
    torch::Tensor numbers;
    archive.read("lines", numbers);
    archive.read("names", names);
    std::vector<std::string> columns;
    std::string text = names.toStringRef();
    for (std::size_t from = 0; !text.empty() && from <= text.size();) {
      const std::size_t to = std::min(text.find('\n', from), text.size());
      columns.push_back(text.substr(from, to - from));
      from = to + 1;
    }
    const auto width = static_cast<std::int64_t>(columns.size()) + 2;
    for (std::int64_t i = 0; i + width <= numbers.size(0); i += width) {
      Line line{static_cast<std::int64_t>(numbers[i].item<double>()), numbers[i + 1].item<double>(), {}};
      for (std::size_t c = 0; c < columns.size(); ++c)
        line.measured.emplace_back(columns[c], numbers[i + 2 + static_cast<std::int64_t>(c)].item<double>());
      lines.push_back(std::move(line));
    }
    return true;
  }

 private:
  std::filesystem::path path_;
  std::string identity_;
};

void write_figures(const TrainingOptions& options, const std::vector<Line>& lines) {
  AtomicFile csv(options.folder / (options.name + ".csv"));
  std::string text = "step,loss";
  for (const auto& [name, value] : lines.front().measured) text += "," + name;
  text += "\n";
  for (const Line& line : lines) {
    text += fmt::format("{},{}", line.step, line.loss);
    for (const auto& [name, value] : line.measured) text += fmt::format(",{}", value);
    text += "\n";
  }
  csv.write(text);
  csv.commit();
  constexpr int kWidth = 900, kHeight = 420;
  Canvas canvas(kWidth, kHeight);
  Plot losses({options.name + ": loss on the training's batches", "step", "loss"});
  Plot held_out({"held out", "step", "as named"});
  std::vector<double> steps, values;
  for (const Line& line : lines) steps.push_back(static_cast<double>(line.step));
  for (const Line& line : lines) values.push_back(line.loss);
  losses.line(steps, values, plot_colour(0));
  for (std::size_t m = 0; m < lines.front().measured.size(); ++m) {
    values.clear();
    for (const Line& line : lines) values.push_back(line.measured[m].second);
    held_out.line(steps, values, plot_colour(m), lines.front().measured[m].first);
  }
  losses.draw(canvas, {0, 0, kWidth / 2.0, kHeight});
  held_out.draw(canvas, {kWidth / 2.0, 0, kWidth / 2.0, kHeight});
  canvas.save_png(options.folder / (options.name + ".png"));
}

}  // namespace

Measurements train(torch::nn::Module& network, const TrainingOptions& options,
                   const std::function<torch::Tensor(std::int64_t step)>& loss,
                   const std::function<Measurements()>& measure) {
  std::filesystem::create_directories(options.folder);
  torch::optim::AdamW optimizer(network.parameters(),
                                torch::optim::AdamWOptions(options.learning_rate).weight_decay(options.weight_decay));
  const Checkpoint checkpoint(options);
  std::vector<Line> lines;
  checkpoint.load(network, optimizer, lines);
  ProgressLine progress("training " + options.name, "steps");
  double sum = 0;
  std::int64_t summed = 0;
  for (std::int64_t step = lines.empty() ? 0 : lines.back().step; step < options.steps; ++step) {
    const double share = static_cast<double>(step) / static_cast<double>(options.steps);
    const double rate = options.learning_rate * (0.505 + 0.495 * std::cos(std::numbers::pi * share));
    for (auto& group : optimizer.param_groups()) static_cast<torch::optim::AdamWOptions&>(group.options()).lr(rate);
    torch::manual_seed(options.seed * 1'000'003 + static_cast<std::uint64_t>(step));
    network.train();
    const torch::Tensor value = loss(step);
    optimizer.zero_grad();
    value.backward();
    torch::nn::utils::clip_grad_norm_(network.parameters(), options.most_gradient);
    optimizer.step();
    sum += value.item<double>();
    ++summed;
    progress.show(static_cast<std::uint64_t>(step + 1), static_cast<std::uint64_t>(options.steps));
    if ((step + 1) % options.measure_every != 0 && step + 1 != options.steps) continue;
    const torch::NoGradGuard guard;
    network.eval();
    lines.push_back({step + 1, sum / static_cast<double>(summed), measure()});
    sum = 0;
    summed = 0;
    checkpoint.save(network, optimizer, lines);
    write_figures(options, lines);
  }
  progress.finish(static_cast<std::uint64_t>(options.steps));
  return lines.empty() ? Measurements{} : lines.back().measured;
}

}  // namespace risorius
