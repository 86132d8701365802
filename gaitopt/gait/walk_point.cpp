// Rows that are a constant matrix times quantities of the walk: their values, and their derivatives
// in x from those of the quantities. Nearly all factors are 0, so that each row keeps the others.
#include "../mechanics/kernels.hpp"

namespace gaitopt {
namespace {

GAITOPT_ANY_PROCESSOR
void add_up(const LinearRows &rows, const Quantities *from, const RowTable &found) {
  const std::ptrdiff_t width = found.width;
  const auto begin = std::lower_bound(rows.numbers.begin(), rows.numbers.end(), found.number);
  for (std::size_t row = begin - rows.numbers.begin(); row < rows.numbers.size(); ++row) {
    const std::ptrdiff_t at_row = rows.numbers[row] - found.number;
    if (at_row >= found.count) return;
    double *__restrict to = found.rows + at_row * width;
    const std::ptrdiff_t first = rows.first[row], last = rows.first[row + 1];
    if (first == last) std::fill(to, to + width, 0.0);
    for (std::ptrdiff_t k = first; k < last; ++k) {
      const LinearRows::Term &term = rows.terms[k];
      const Quantities &source = from[term.source];
      const double *__restrict at =
          source.data + term.instant * source.by_instant + term.entry * source.by_entry;
      const double factor = term.factor;
      if (k == first)
        for (std::ptrdiff_t i = 0; i < width; ++i) to[i] = factor * at[i];
      else
        for (std::ptrdiff_t i = 0; i < width; ++i) to[i] += factor * at[i];
    }
  }
}

}  // namespace

void LinearRows::add(std::ptrdiff_t number, const long *sources, const long *entries,
                     std::ptrdiff_t size, const long *instants, std::ptrdiff_t count,
                     const double *matrix, std::ptrdiff_t height, std::ptrdiff_t apart) {
  for (std::ptrdiff_t k = 0; k < count; ++k)
    for (std::ptrdiff_t row = 0; row < height; ++row) {
      const double *factors = matrix + k * apart + row * size;
      for (std::ptrdiff_t i = 0; i < size; ++i)
        if (factors[i] != 0.0) terms.push_back({sources[i], instants[k], entries[i], factors[i]});
      numbers.push_back(number++);
      first.push_back(static_cast<std::ptrdiff_t>(terms.size()));
    }
}

void linear_rows(const LinearRows &rows, const Quantities *from, const RowTable &found) {
  add_up(rows, from, found);
}

}  // namespace gaitopt
