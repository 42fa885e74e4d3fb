#include "proto/space/trig.h"

#include <cmath>

namespace foreland::proto {

namespace {

constexpr double kPio2 = 1.57079632679489655800e+00;
constexpr double kPio2Tail = 6.12323399573676603587e-17;
constexpr double kPi = 3.14159265358979311600e+00;

double sinKernel(double x, double tail) {
  const double z = x * x, v = z * x;
  const double r =
      8.33333333332248946124e-03 +
      z * (-1.98412698298579493134e-04 +
           z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  return x - ((z * (0.5 * tail - v * r) - tail) - v * -1.66666666666666324348e-01);
}

double cosKernel(double x, double tail) {
  const double z = x * x;
  const double r = z * (4.16666666666666019037e-02 +
                        z * (-1.38888888888741095749e-03 +
                             z * (2.48015872894767294178e-05 +
                                  z * (-2.75573143513906633035e-07 +
                                       z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z, w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * r - x * tail));
}

// fdlibm's atan for x >= 0.
double arcTan(double x) {
  constexpr double kHigh[] = {4.63647609000806093515e-01, 7.85398163397448278999e-01, 9.82793723247329054082e-01,
                              kPio2};
  constexpr double kLow[] = {2.26987774529616870924e-17, 3.06161699786838301793e-17, 1.39033110312309984516e-17,
                             kPio2Tail};
  constexpr double kA[] = {3.33333333333329318027e-01,  -1.99999999998764832476e-01, 1.42857142725034663711e-01,
                           -1.11111104054623557880e-01, 9.09088713343650656196e-02,  -7.69187620504482999495e-02,
                           6.66107313738753120669e-02,  -5.83357013379057348645e-02, 4.97687799461593236017e-02,
                           -3.65315727442169155270e-02, 1.62858201153657823623e-02};
  int range = -1;
  if (x >= 0.4375) {
    if (x < 0.6875)
      range = 0, x = (2.0 * x - 1.0) / (2.0 + x);
    else if (x < 1.1875)
      range = 1, x = (x - 1.0) / (x + 1.0);
    else if (x < 2.4375)
      range = 2, x = (x - 1.5) / (1.0 + 1.5 * x);
    else
      range = 3, x = -1.0 / x;
  }
  const double z = x * x, w = z * z;
  const double s1 = z * (kA[0] + w * (kA[2] + w * (kA[4] + w * (kA[6] + w * (kA[8] + w * kA[10])))));
  const double s2 = w * (kA[1] + w * (kA[3] + w * (kA[5] + w * (kA[7] + w * kA[9]))));
  if (range < 0) return x - x * (s1 + s2);
  return kHigh[range] - ((x * (s1 + s2) - kLow[range]) - x);
}

}  // namespace

SinCos sinCos(double angle_rad) {
  const double turns = std::nearbyint(angle_rad / kPio2);
  const double reduced =
      angle_rad - turns * kPio2;  // exact enough: |turns| stays small, kPio2 * turns loses under 2 ulp
  const double tail = -turns * kPio2Tail;
  const double s = sinKernel(reduced, tail), c = cosKernel(reduced, tail);
  switch (static_cast<int>(turns) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double arcTan2(double y, double x) {
  if (x == 0 && y == 0) return 0;
  const double ay = std::fabs(y), ax = std::fabs(x);
  double angle = ax >= ay ? arcTan(ay / ax) : kPio2 - arcTan(ax / ay);
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace foreland::proto
