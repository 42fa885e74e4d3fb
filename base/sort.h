// Sorting as std::sort does it, and in WebAssembly in little code: each instance of libc++'s takes 3 to 7 kB there, of
// which a page waits for all before its first picture, and most sort a few things a keyframe. Elements that are equal
// come in any order. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <utility>

namespace foreland {

// A heap that gives up its greatest element again and again: no more than 2 n log2 n comparisons, whatever comes in.
template <class Iterator, class Less = std::less<>>
void heapSort(Iterator begin, Iterator end, Less less = {}) {
  using Offset = typename std::iterator_traits<Iterator>::difference_type;
  Offset left = end - begin, root = left / 2;
  while (left > 1) {
    if (root > 0)
      --root;  // the heap grows downwards until it holds all
    else
      std::swap(begin[0], begin[--left]);
    auto moved = std::move(begin[root]);
    Offset hole = root;
    for (Offset child; (child = 2 * hole + 1) < left; hole = child) {
      if (child + 1 < left && less(begin[child], begin[child + 1])) ++child;
      if (!less(moved, begin[child])) break;
      begin[hole] = std::move(begin[child]);
    }
    begin[hole] = std::move(moved);
  }
}

template <class Iterator, class Less = std::less<>>
void sort(Iterator begin, Iterator end, Less less = {}) {
#ifdef __wasm__
  heapSort(begin, end, less);
#else
  std::sort(begin, end, less);
#endif
}

}  // namespace foreland
