// Sine, cosine and arc tangent that give the same bits natively and in WebAssembly, where the platforms' libraries
// differ in the last place. Kernels after fdlibm (Sun Microsystems, public domain). Error below 2 ulp for |x| <= 8;
// callers pass angles of latitude and longitude. Pure; any thread.
#pragma once

namespace foreland::proto {

struct SinCos {
  double sin;
  double cos;
};

[[nodiscard]] SinCos sinCos(double angle_rad);
[[nodiscard]] double arcTan2(double y, double x);

}  // namespace foreland::proto
