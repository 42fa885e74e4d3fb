// Sine, cosine and tangent without angles beyond 1.6 million radians, which nothing in the client has: they are of
// rotations between poses, of latitudes, of the sun's height and of regions (unless a server lies about these).
// Wherever libc would bring such an angle back to a quarter turn, with 4 kB of arithmetic in hundreds of digits, it is
// taken for zero. The linker takes this in place of libc's.
extern "C" int __rem_pio2_large(double* /*parts*/, double* rest, int /*exponent*/, int /*count*/, int /*precision*/);

extern "C" int __rem_pio2_large(double*, double* rest, int, int, int) {
  rest[0] = rest[1] = 0;
  return 0;
}
