// Instructions that count and take apart the bits of words, chosen at run time as those for vectors are (vectors.h):
// where programs are built for every processor of x86-64, counting the bits of a word is a call that takes a dozen
// instructions. Pure; any thread.
#pragma once

namespace foreland {

#if defined(__x86_64__) && !(defined(__POPCNT__) && defined(__BMI2__))

// Of what runWithBitInstructions calls, and elsewhere left to the compiler: a module of WebAssembly is to stay small.
#define FORELAND_WITH_BIT_INSTRUCTIONS __attribute__((always_inline))

namespace bit_instructions_detail {

inline const bool has =
    __builtin_cpu_supports("popcnt") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");

template <class Work>
[[gnu::target("popcnt,bmi,bmi2"), gnu::noinline]] void run(const Work& work) {
  work();
}

}  // namespace bit_instructions_detail

// Calls work(), which is FORELAND_WITH_BIT_INSTRUCTIONS, as is what it calls.
template <class Work>
void runWithBitInstructions(const Work& work) {
  if (bit_instructions_detail::has) return bit_instructions_detail::run(work);
  work();
}

#else

#define FORELAND_WITH_BIT_INSTRUCTIONS

template <class Work>
void runWithBitInstructions(const Work& work) {
  work();
}

#endif

}  // namespace foreland
