#include "clump_motion.h"

#include <cmath>
#include <cstring>

#include "clones.h"

namespace ballast {

ClumpBatch::ClumpBatch() {
  std::memset(static_cast<void *>(this), 0, sizeof(*this));
  // lanes without a clump compute too
  for (int k = 0; k < SIZE; k++) mass[k] = inertia_transverse[k] = inertia_axial[k] = quaternion[0][k] = axis[2][k] = 1.0;
}

namespace {

/// Below this square of a half angle the series of cosine and sine are exact to the last digit.
const double SMALL2 = 0.01;

inline double sign(double value) { return value > 0.0 ? 1.0 : (value < 0.0 ? -1.0 : 0.0); }

inline double cosine_series(double h2) {
  return 1.0 - h2 * (1.0 / 2.0 - h2 * (1.0 / 24.0 - h2 * (1.0 / 720.0 - h2 * (1.0 / 40320.0 - h2 / 3628800.0))));
}

inline double sine_over_angle_series(double h2) {
  return 1.0 - h2 * (1.0 / 6.0 - h2 * (1.0 / 120.0 - h2 * (1.0 / 5040.0 - h2 * (1.0 / 362880.0 - h2 / 39916800.0))));
}

/// Spin of an axisymmetric body: L / I_t + (L.axis) (1 / I_a - 1 / I_t) axis.
inline __attribute__((always_inline)) void set_spin(ClumpBatch &c, int k, double nx, double ny, double nz) {
  const double lx = c.momentum[0][k], ly = c.momentum[1][k], lz = c.momentum[2][k];
  const double across = 1.0 / c.inertia_transverse[k];
  const double along = (lx * nx + ly * ny + lz * nz) * (1.0 / c.inertia_axial[k] - across);
  c.spin[0][k] = lx * across + along * nx;
  c.spin[1][k] = ly * across + along * ny;
  c.spin[2][k] = lz * across + along * nz;
}

BALLAST_CLONES void kick_lanes(ClumpBatch &c, double time_step) {
  const double half = 0.5 * time_step;
#pragma omp simd
  for (int k = 0; k < ClumpBatch::SIZE; k++) {
    const double per_mass = half / c.mass[k];
    for (int d = 0; d < 3; d++) {
      c.velocity[d][k] += per_mass * c.force[d][k];
      c.momentum[d][k] += half * c.torque[d][k];
    }
    set_spin(c, k, c.axis[0][k], c.axis[1][k], c.axis[2][k]);
  }
}

/// Angles by which the orientation turns in a step, and the largest square of a half angle.
BALLAST_CLONES double kick_and_find_angles(ClumpBatch &c, double time_step) {
  const double half = 0.5 * time_step;
  double largest = 0.0;
#pragma omp simd reduction(max : largest)
  for (int k = 0; k < ClumpBatch::SIZE; k++) {
    const double per_mass = half / c.mass[k];
    for (int d = 0; d < 3; d++) {
      c.velocity[d][k] += per_mass * c.force[d][k];
      c.centre[d][k] += time_step * c.velocity[d][k];
      c.momentum[d][k] += half * c.torque[d][k];
    }
    const double lx = c.momentum[0][k], ly = c.momentum[1][k], lz = c.momentum[2][k];
    const double across = 1.0 / c.inertia_transverse[k];
    const double along = lx * c.axis[0][k] + ly * c.axis[1][k] + lz * c.axis[2][k];
    const double scale = half * across;
    c.half_angle2[k] = scale * scale * (lx * lx + ly * ly + lz * lz);
    c.half_turn[k] = half * along * (1.0 / c.inertia_axial[k] - across);
    const double h2 = c.half_angle2[k], t2 = c.half_turn[k] * c.half_turn[k];
    c.cosine[k] = cosine_series(h2);
    c.sine_over_angle[k] = sine_over_angle_series(h2);
    c.turn_cosine[k] = cosine_series(t2);
    c.turn_sine_over_angle[k] = sine_over_angle_series(t2);
    const double more = h2 > t2 ? h2 : t2;
    largest = more > largest ? more : largest;
  }
  return largest;
}

/// For spins that no bed has.
void exact_angles(ClumpBatch &c) {
  for (int k = 0; k < ClumpBatch::SIZE; k++) {
    const double h = std::sqrt(c.half_angle2[k]), t = c.half_turn[k];
    c.cosine[k] = std::cos(h);
    c.sine_over_angle[k] = h > 0.0 ? std::sin(h) / h : 1.0;
    c.turn_cosine[k] = std::cos(t);
    c.turn_sine_over_angle[k] = t != 0.0 ? std::sin(t) / t : 1.0;
  }
}

BALLAST_CLONES void turn_lanes(ClumpBatch &c, double time_step) {
#pragma omp simd
  for (int k = 0; k < ClumpBatch::SIZE; k++) {
    // new quaternion = rotation about L (space) x old x rotation about the axis (body)
    const double scale = 0.5 * time_step / c.inertia_transverse[k] * c.sine_over_angle[k];
    const double pw = c.cosine[k], px = scale * c.momentum[0][k], py = scale * c.momentum[1][k], pz = scale * c.momentum[2][k];
    const double qw = c.quaternion[0][k], qx = c.quaternion[1][k], qy = c.quaternion[2][k], qz = c.quaternion[3][k];
    const double aw = pw * qw - px * qx - py * qy - pz * qz;
    const double ax = pw * qx + px * qw + py * qz - pz * qy;
    const double ay = pw * qy + py * qw + pz * qx - px * qz;
    const double az = pw * qz + pz * qw + px * qy - py * qx;
    const double sw = c.turn_cosine[k], sz = c.half_turn[k] * c.turn_sine_over_angle[k];
    double w = aw * sw - az * sz, x = ax * sw + ay * sz, y = ay * sw - ax * sz, z = az * sw + aw * sz;
    const double unit = 1.0 / std::sqrt(w * w + x * x + y * y + z * z);
    w *= unit;
    x *= unit;
    y *= unit;
    z *= unit;
    c.quaternion[0][k] = w;
    c.quaternion[1][k] = x;
    c.quaternion[2][k] = y;
    c.quaternion[3][k] = z;
    const double nx = 2.0 * (x * z + w * y), ny = 2.0 * (y * z - w * x), nz = w * w - x * x - y * y + z * z;
    // the axis in the middle of the step: the mean of both ends, within the square of the angle
    set_spin(c, k, 0.5 * (nx + c.axis[0][k]), 0.5 * (ny + c.axis[1][k]), 0.5 * (nz + c.axis[2][k]));
    c.axis[0][k] = nx;
    c.axis[1][k] = ny;
    c.axis[2][k] = nz;
    c.axis_x[0][k] = w * w + x * x - y * y - z * z;
    c.axis_x[1][k] = 2.0 * (x * y + w * z);
    c.axis_x[2][k] = 2.0 * (x * z - w * y);
    c.axis_y[0][k] = 2.0 * (x * y - w * z);
    c.axis_y[1][k] = w * w - x * x + y * y - z * z;
    c.axis_y[2][k] = 2.0 * (y * z + w * x);
  }
}

}  // namespace

void kick_and_drift(ClumpBatch &clumps, double time_step) {
  if (kick_and_find_angles(clumps, time_step) > SMALL2) exact_angles(clumps);
  turn_lanes(clumps, time_step);
}

void kick(ClumpBatch &clumps, double time_step) { kick_lanes(clumps, time_step); }

void damp(ClumpBatch &c, double alpha, double ahead) {
  for (int k = 0; k < ClumpBatch::SIZE; k++)
    for (int d = 0; d < 3; d++) {
      double &force = c.force[d][k], &torque = c.torque[d][k];
      force *= 1.0 - alpha * sign(force * (c.velocity[d][k] + ahead / c.mass[k] * force));
      torque *= 1.0 - alpha * sign(torque * c.spin[d][k]);
    }
}

}  // namespace ballast
