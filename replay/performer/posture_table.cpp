#include "replay/performer/posture_table.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace risorius {
namespace {

constexpr double kFarthestScore = 2.6;  // share 0.995: a recording of minutes says nothing beyond

double share_of_score(double score) { return 0.5 * std::erfc(-score / std::numbers::sqrt2); }

/// By bisection: exact to the last bits and needed a few times per action only.
double score_of_share(double share) {
  double low = -6, high = 6;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (share_of_score(middle) < share ? low : high) = middle;
  }
  return low;
}

}  // namespace

std::vector<double> rank_shares(std::span<const double> values) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < values.size(); ++i) order.emplace_back(values[i], i);
  std::sort(order.begin(), order.end());
  std::vector<double> shares(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && order[end].first <= order[i].first) ++end;
    const double share = 0.5 * static_cast<double>(i + end) / static_cast<double>(order.size());
    for (; i < end; ++i) shares[order[i].second] = share;
  }
  return shares;
}

std::vector<double> normal_scores(std::span<const double> values) {
  std::vector<double> scores = rank_shares(values);
  for (double& score : scores) score = score_of_share(score);
  return scores;
}

PostureSampler::PostureSampler(const PostureTable& table)
    : table_(table), scores_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(table.aus.size()))) {
  const auto count = static_cast<Eigen::Index>(table.aus.size());
  if (table.levels.size() != table.aus.size() || table.correlation.rows() != count || table.correlation.cols() != count)
    throw std::invalid_argument("PostureSampler: levels, correlation and AUs differ in number");
  const Eigen::LLT<Eigen::MatrixXd> factors(table.correlation);
  if (count > 0 && factors.info() != Eigen::Success)
    throw std::invalid_argument("PostureSampler: the correlation is not positive definite");
  root_ = factors.matrixL();
}

std::optional<std::size_t> PostureSampler::find(std::string_view au) const {
  const auto found = std::find(table_.aus.begin(), table_.aus.end(), au);
  if (found == table_.aus.end()) return std::nullopt;
  return static_cast<std::size_t>(found - table_.aus.begin());
}

void PostureSampler::renew(double kept, Random& random) {
  Eigen::VectorXd fresh(scores_.size());
  for (double& value : fresh) value = random.gaussian();
  scores_ = kept * scores_ + std::sqrt(std::max(0.0, 1 - kept * kept)) * (root_ * fresh);
}

void PostureSampler::lead(std::span<const Lead> leads) {
  if (leads.empty()) return;
  const auto count = static_cast<Eigen::Index>(leads.size());
  Eigen::VectorXd missing(count);
  Eigen::MatrixXd among(count, count), along(scores_.size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<Eigen::Index>(leads[static_cast<std::size_t>(i)].au);
    const double wanted =
        std::clamp(score_of_share(leads[static_cast<std::size_t>(i)].share), -kFarthestScore, kFarthestScore);
    missing[i] = wanted - scores_[at];
    along.col(i) = table_.correlation.col(at);
    for (Eigen::Index j = 0; j < count; ++j)
      among(j, i) = table_.correlation(static_cast<Eigen::Index>(leads[static_cast<std::size_t>(j)].au), at);
  }
  scores_ += along * among.llt().solve(missing);
}

double PostureSampler::level(std::size_t au) const {
  const double share = share_of_score(scores_[static_cast<Eigen::Index>(au)]);
  const auto& shares = PostureTable::kShares;
  const auto above = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::upper_bound(shares.begin(), shares.end(), share) - shares.begin()), 1,
      shares.size() - 1);
  const double u = (share - shares[above - 1]) / (shares[above] - shares[above - 1]);
  const PostureTable::Levels& levels = table_.levels[au];
  return (1 - u) * levels[above - 1] + u * levels[above];
}

double PostureSampler::share_of(std::size_t au, double level) const {
  const PostureTable::Levels& levels = table_.levels[au];
  const auto above = static_cast<std::size_t>(std::upper_bound(levels.begin(), levels.end(), level) - levels.begin());
  if (above == 0) return 0;
  if (above == levels.size()) return 1;
  const double u = (level - levels[above - 1]) / (levels[above] - levels[above - 1]);
  return (1 - u) * PostureTable::kShares[above - 1] + u * PostureTable::kShares[above];
}

}  // namespace risorius
