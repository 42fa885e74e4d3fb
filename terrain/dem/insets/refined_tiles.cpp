#include "terrain/dem/insets/refined_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

namespace foreland::terrain {

namespace {

constexpr int kTileLog2 = 8;
constexpr uint32_t kTileCells = 1u << kTileLog2;
constexpr int kBlockLog2 = 5;         // pages have nodes of 32 x 32 cells
constexpr double kRounding_m = 1e-3;  // of floats, in heights that are the same

// Heights of a window, of which those at multiples of a step count.
struct Grid {
  const std::vector<float>& metres;
  RefinedWindow window;
  uint32_t step;

  double at(uint32_t x, uint32_t y) const {
    const glm::uvec2 p = glm::uvec2(x, y) * step - window.first;
    return metres[size_t{p.y} * window.size.x + p.x];
  }
  // At a position of the refined lattice.
  double drawn(glm::dvec2 p) const {
    const glm::uvec2 last = (window.first + window.size - 1u) / step;
    return drawnHeight(last, p / double(step), [&](uint32_t x, uint32_t y) { return at(x, y); });
  }
  double bilinear(glm::dvec2 p) const {
    const glm::uvec2 last = (window.first + window.size - 1u) / step;
    p /= double(step);
    const glm::uvec2 cell = glm::min(glm::uvec2(p), last - 1u);
    const glm::dvec2 t = p - glm::dvec2(cell);
    const auto along = [&](uint32_t y) { return (1 - t.x) * at(cell.x, y) + t.x * at(cell.x + 1, y); };
    return (1 - t.y) * along(cell.y) + t.y * along(cell.y + 1);
  }
};

// A sample of a layer over a window.
struct LayerSample {
  glm::dvec2 at;  // of the refined lattice
  float metres;
};

// The samples of a layer around which its heights alone count.
std::vector<LayerSample> samplesOf(const LayerStack& stack, int16_t index, int depth, const RefinedWindow& window,
                                   const std::vector<int16_t>& owners) {
  const Layer& layer = stack.layers[static_cast<size_t>(index)];
  const double scale = std::ldexp(1.0, depth);
  const glm::dvec2 first(window.first), last = first + glm::dvec2(window.size - 1u);
  // The columns and rows that the window's border reaches.
  std::vector<glm::dvec2> border;
  for (uint32_t i = 0; i < window.size.x; ++i)
    border.emplace_back((first.x + i) / scale, first.y / scale),
        border.emplace_back((first.x + i) / scale, last.y / scale);
  for (uint32_t i = 0; i < window.size.y; ++i)
    border.emplace_back(first.x / scale, (first.y + i) / scale),
        border.emplace_back(last.x / scale, (first.y + i) / scale);
  layer.to_samples(border);
  glm::dvec2 low(layer.samples.width, layer.samples.height), high(0);
  for (const glm::dvec2& p : border)
    if (!std::isnan(p.x)) low = glm::min(low, p), high = glm::max(high, p);
  low = glm::max(glm::floor(low) - 1.0, glm::dvec2(0));
  high = glm::min(glm::ceil(high) + 1.0, glm::dvec2(layer.samples.width - 1.0, layer.samples.height - 1.0));
  std::vector<LayerSample> out;
  std::vector<glm::dvec2> row;
  for (double y = low.y; y <= high.y; ++y) {
    row.clear();
    for (double x = low.x; x <= high.x; ++x) row.emplace_back(x, y);
    layer.to_lattice(row);
    for (size_t i = 0; i < row.size(); ++i) {
      const glm::dvec2 p = row[i] * scale;
      const float h = layer.samples.at(static_cast<uint32_t>(low.x + double(i)), static_cast<uint32_t>(y));
      if (std::isnan(h) || !(p.x >= first.x && p.y >= first.y && p.x <= last.x && p.y <= last.y)) continue;
      const glm::uvec2 cell = glm::min(glm::uvec2(p - first), window.size - 2u);
      const auto isOwned = [&](uint32_t x, uint32_t y_) { return owners[size_t{y_} * window.size.x + x] == index; };
      if (isOwned(cell.x, cell.y) && isOwned(cell.x + 1, cell.y) && isOwned(cell.x, cell.y + 1) &&
          isOwned(cell.x + 1, cell.y + 1))
        out.push_back({p, h});
    }
  }
  return out;
}

double residualOf(const Grid& grid, const std::vector<LayerSample>& samples) {
  double largest_m = 0;
  for (const LayerSample& s : samples)
    largest_m =
        std::max({largest_m, std::fabs(grid.drawn(s.at) - s.metres), std::fabs(grid.bilinear(s.at) - s.metres)});
  return largest_m;
}

// Whether a grid is within a bound of the heights that it takes some of, in a part of its window.
bool isWithin(const Grid& grid, double bound_m, const RefinedWindow& part) {
  const glm::uvec2 from = part.first - grid.window.first, end = from + part.size;
  for (uint32_t y = from.y; y < end.y; ++y)
    for (uint32_t x = from.x; x < end.x; ++x) {
      const double h = grid.metres[size_t{y} * grid.window.size.x + x];
      if (!(std::fabs(grid.drawn(glm::dvec2(grid.window.first + glm::uvec2(x, y))) - h) <= bound_m)) return false;
    }
  return true;
}

// What is drawn at full resolution and what is bilinear, from a sample's height: the larger difference.
double differenceOf(const LatticeHeightAt& surface, glm::uvec2 last, glm::dvec2 p, float metres) {
  const glm::uvec2 cell = glm::min(glm::uvec2(p), last - 1u);
  const std::array<double, 4> corners{surface(cell), surface(cell + glm::uvec2(1, 0)), surface(cell + glm::uvec2(0, 1)),
                                      surface(cell + 1u)};
  const auto at = [&](uint32_t x, uint32_t y) { return corners[2 * (y - cell.y) + (x - cell.x)]; };
  const glm::dvec2 t = p - glm::dvec2(cell);
  const auto along = [&](uint32_t y) { return (1 - t.x) * at(cell.x, y) + t.x * at(cell.x + 1, y); };
  const double bilinear = (1 - t.y) * along(cell.y) + t.y * along(cell.y + 1);
  return std::max(std::fabs(drawnHeight(last, p, at) - metres), std::fabs(bilinear - metres));
}

}  // namespace

RefinedTiles::RefinedTiles(const LayerStack& stack, Options options, std::span<Overlap> overlaps)
    : stack_(stack),
      options_(std::move(options)),
      last_(glm::uvec2(stack.base.width - 1, stack.base.height - 1) << static_cast<uint32_t>(options_.depth)),
      roots_((glm::uvec2(stack.base.width, stack.base.height) - 2u) / kTileCells + 1u),
      branches_(size_t{roots_.x} * roots_.y),
      residuals_(stack.layers.size()) {
  options_.residual_m = std::max(options_.residual_m, kRounding_m);
  for (uint32_t y = 0; y < roots_.y; ++y)
    for (uint32_t x = 0; x < roots_.x; ++x) grow(size_t{y} * roots_.x + x, 0, {x, y}, overlaps);
}

// The tile of a level's lattice, in positions of one that is halved `own` times.
RefinedWindow RefinedTiles::windowOf(int level, glm::uvec2 index, int own) const {
  const uint32_t side = kTileCells >> (level - own);
  const glm::uvec2 first = index * side, last = last_ >> static_cast<uint32_t>(options_.depth - own);
  return {first, glm::min(glm::uvec2(side), last - first) + 1u};
}

// The most halvings that a layer over a window takes; -1 if there is none.
int RefinedTiles::levelFor(int level, const RefinedWindow& window) const {
  const double scale = std::ldexp(1.0, -level);
  const glm::dvec2 low = glm::dvec2(window.first) * scale, high = low + glm::dvec2(window.size - 1u) * scale;
  int most = -1;
  for (size_t i = 0; i < stack_.layers.size(); ++i) {
    const Layer& layer = stack_.layers[i];
    if (layer.low.x <= high.x && layer.low.y <= high.y && layer.high.x >= low.x && layer.high.y >= low.y)
      most = std::max(most, options_.depths[i]);
  }
  return most;
}

void RefinedTiles::grow(size_t branch, int level, glm::uvec2 index, std::span<Overlap> overlaps) {
  const int wanted = levelFor(level, windowOf(level, index, level));
  if (wanted < 0) return;
  if (wanted <= level) {
    const int least = std::max(0, level - kTileLog2), own = std::max(wanted, least);
    branches_[branch].tile = static_cast<int32_t>(tiles_.size());
    tiles_.push_back(makeTile(own, least, windowOf(level, index, own), overlaps));
    return;
  }
  const size_t children = branches_.size();
  branches_[branch].children = static_cast<int32_t>(children);
  branches_.resize(children + 4);
  const glm::uvec2 last = last_ >> static_cast<uint32_t>(options_.depth - level - 1);
  for (uint32_t k = 0; k < 4; ++k)
    if (const glm::uvec2 at = 2u * index + glm::uvec2(k % 2, k / 2);
        at.x * kTileCells < last.x && at.y * kTileCells < last.y)
      grow(children + k, level + 1, at, overlaps);
}

RefinedTiles::Tile RefinedTiles::makeTile(int own, int least_depth, const RefinedWindow& window,
                                          std::span<Overlap> overlaps) {
  MergedWindow merged = merge(stack_, own, window, overlaps);
  std::vector<std::vector<LayerSample>> samples;
  for (size_t i = 0; i < stack_.layers.size(); ++i)
    samples.push_back(samplesOf(stack_, static_cast<int16_t>(i), own, window, merged.owners));
  std::vector<double> residuals(samples.size());
  Tile tile{.own = own, .window = window, .metres = {}};
  for (tile.depth = least_depth;; ++tile.depth) {
    const Grid grid{merged.metres, window, 1u << (own - tile.depth)};
    for (size_t i = 0; i < samples.size(); ++i) residuals[i] = residualOf(grid, samples[i]);
    if (tile.depth == own) break;
    if (std::ranges::all_of(residuals, [&](double r) { return r <= options_.residual_m; }) &&
        isWithin(grid, options_.residual_m, {window.first, window.size}))
      break;
  }
  for (size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].empty()) continue;
    residuals_[i].largest_m = std::max(residuals_[i].largest_m.value_or(0), residuals[i]);
    residuals_[i].samples += samples[i].size();
  }
  const uint32_t step = 1u << (own - tile.depth);
  for (uint32_t y = 0; y < window.size.y; y += step)
    for (uint32_t x = 0; x < window.size.x; x += step)
      tile.metres.push_back(merged.metres[size_t{y} * window.size.x + x]);
  if (!options_.is_sparse) return tile;
  tile.block_depths = blockDepths(merged.metres, window, own, {least_depth, tile.depth});
  tile.samples.resize(samples.size());
  for (size_t i = 0; i < samples.size(); ++i)
    for (const LayerSample& s : samples[i]) {
      const glm::dvec2 p = s.at - glm::dvec2(window.first);
      tile.samples[i].push_back({static_cast<float>(p.x), static_cast<float>(p.y), s.metres});
    }
  return tile;
}

// For the blocks of a window, row by row, the fewest halvings that lose nothing of its heights, and no more than layers
// over them take.
std::vector<int8_t> RefinedTiles::blockDepths(const std::vector<float>& metres, const RefinedWindow& window, int own,
                                              Depths depths) const {
  std::vector<int8_t> out;
  const glm::uvec2 cells = window.size - 1u;
  constexpr uint32_t kSide = 1u << kBlockLog2;
  for (uint32_t y = 0; y < cells.y; y += kSide)
    for (uint32_t x = 0; x < cells.x; x += kSide) {
      const glm::uvec2 at(x, y);
      const RefinedWindow block{window.first + at, glm::min(glm::uvec2(kSide), cells - at) + 1u};
      const int most = std::clamp(levelFor(own, block), depths.least, depths.most);
      int depth = std::min(most, std::max(depths.least, own - kBlockLog2));
      while (depth < most && !isWithin(Grid{metres, window, 1u << (own - depth)}, kRounding_m, block)) ++depth;
      out.push_back(static_cast<int8_t>(depth));
    }
  return out;
}

template <class Visit>
void RefinedTiles::visitBranch(size_t branch, int level, glm::uvec2 index, glm::uvec2 low, glm::uvec2 high,
                               const Visit& visit) const {
  const Branch& b = branches_[branch];
  if (b.tile < 0 && b.children < 0) return;
  const auto shift = static_cast<uint32_t>(options_.depth - level);
  const glm::uvec2 first = (index * kTileCells) << shift, end = first + (kTileCells << shift);
  if (first.x > high.x || first.y > high.y || end.x < low.x || end.y < low.y) return;
  if (b.tile >= 0) return visit(tiles_[static_cast<size_t>(b.tile)]);
  for (uint32_t k = 0; k < 4; ++k)
    visitBranch(static_cast<size_t>(b.children) + k, level + 1, 2u * index + glm::uvec2(k % 2, k / 2), low, high,
                visit);
}

template <class Visit>
void RefinedTiles::forEachIn(glm::uvec2 low, glm::uvec2 high, const Visit& visit) const {
  const uint32_t side = kTileCells << static_cast<uint32_t>(options_.depth);
  const glm::uvec2 last = glm::min(high / side, roots_ - 1u),
                   first = glm::min((glm::max(low, 1u) - 1u) / side, roots_ - 1u);
  for (uint32_t y = first.y; y <= last.y; ++y)
    for (uint32_t x = first.x; x <= last.x; ++x) visitBranch(size_t{y} * roots_.x + x, 0, {x, y}, low, high, visit);
}

double RefinedTiles::heightIn(const Tile& tile, glm::uvec2 at) const {
  const uint32_t step = 1u << (tile.own - tile.depth);
  const glm::uvec2 first = tile.window.first / step, last = (tile.window.first + tile.window.size - 1u) / step;
  const uint32_t width = last.x - first.x + 1;
  return drawnHeight(last, glm::dvec2(at) * std::ldexp(1.0, tile.depth - options_.depth), [&](uint32_t x, uint32_t y) {
    return double{tile.metres[size_t{y - first.y} * width + (x - first.x)]};
  });
}

double RefinedTiles::heightAt(glm::uvec2 at) const {
  const Tile* deepest = nullptr;
  forEachIn(at, at, [&](const Tile& tile) {
    if (deepest == nullptr || tile.depth > deepest->depth) deepest = &tile;
  });
  if (deepest != nullptr) return heightIn(*deepest, at);
  const Samples& ground = stack_.bottom.metres.empty() ? stack_.base : stack_.bottom;
  return drawnHeight(glm::uvec2(ground.width - 1, ground.height - 1), glm::dvec2(at) * std::ldexp(1.0, -options_.depth),
                     [&](uint32_t x, uint32_t y) { return double{ground.at(x, y)}; });
}

void RefinedTiles::readRow(uint32_t y, std::span<float> out) const {
  for (uint32_t x = 0; x < out.size(); ++x) out[x] = static_cast<float>(heightAt({x, y}));
}

bool RefinedTiles::isFineIn(uint32_t spacing, glm::uvec2 low, glm::uvec2 size) const {
  const glm::uvec2 high = low + size - 1u;
  bool is_fine = false;
  forEachIn(low, high, [&](const Tile& tile) {
    if (is_fine || 1u << (options_.depth - tile.depth) > spacing) return;
    const auto shift = static_cast<uint32_t>(options_.depth - tile.own);
    const glm::uvec2 cells = tile.window.size - 1u, blocks = ((cells - 1u) >> uint32_t{kBlockLog2}) + 1u;
    for (uint32_t j = 0; j < blocks.y; ++j)
      for (uint32_t i = 0; i < blocks.x; ++i) {
        const glm::uvec2 at = glm::uvec2(i, j) << uint32_t{kBlockLog2};
        const glm::uvec2 first = (tile.window.first + at) << shift,
                         end = (tile.window.first + glm::min(at + (1u << kBlockLog2), cells)) << shift;
        is_fine = is_fine || (first.x <= high.x && first.y <= high.y && end.x >= low.x && end.y >= low.y &&
                              1u << (options_.depth - tile.block_depths[size_t{j} * blocks.x + i]) <= spacing);
      }
  });
  return is_fine;
}

std::vector<LayerResidual> RefinedTiles::residualsAgainst(const LatticeHeightAt& surface) const {
  std::vector<LayerResidual> residuals(stack_.layers.size());
  for (const Tile& tile : tiles_) {
    const double scale = std::ldexp(1.0, options_.depth - tile.own);
    const glm::dvec2 first(tile.window.first);
    for (size_t i = 0; i < tile.samples.size(); ++i)
      for (const Kept& s : tile.samples[i]) {
        const double off_m = differenceOf(surface, last_, (first + glm::dvec2(s.x, s.y)) * scale, s.metres);
        residuals[i].largest_m = std::max(residuals[i].largest_m.value_or(0), off_m);
        ++residuals[i].samples;
      }
  }
  return residuals;
}

}  // namespace foreland::terrain
