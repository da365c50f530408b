// The paper's contact laws as plain formulas (equation numbers of Talebiahooie et al. 2021). SI units; forces in N,
// positive = repulsive. Free of branches, so that the compiler can work on several contacts at once: flags are 0.0
// or 1.0.
#ifndef BALLAST_CONTACT_LAWS_H
#define BALLAST_CONTACT_LAWS_H

#include <cmath>

namespace ballast {

/// Elastic normal force, tangent stiffnesses and dashpot of one contact.
struct NormalResponse {
  double elastic_force;     ///< limits the shear force; never contains the dashpot
  double total_force;       ///< elastic force plus dashpot
  double shear_stiffness;   ///< N/m
  double dashpot_at_limit;  ///< 1 where the hysteretic dashpot is capped
};

/// Linear law (eq. 1-2, 5-7): spring and dashpot, F = k_n u + 2 beta sqrt(m k_n) v. The dashpot may pull: restitution
/// exp(-pi beta / sqrt(1 - beta^2)) holds only so. mass = m1 m2 / (m1 + m2), or m1 against a wall, of whole clumps.
inline NormalResponse linear_normal(double overlap, double closing_speed, double mass, double normal_stiffness,
                                    double shear_stiffness, double damping_ratio) {
  const double elastic = normal_stiffness * overlap;
  const double dashpot = 2.0 * damping_ratio * std::sqrt(mass * normal_stiffness) * closing_speed;
  return {elastic, elastic + dashpot, shear_stiffness, 0.0};
}

/// Damping factor D of eq. 16, as repaired in analysis/contact_laws.py: 0 Gonthier, 1 Lankarani-Nikravesh, 2
/// Zhiying-Qishao.
inline double damping_factor(double restitution, int damping_mode) {
  const double loss = 1.0 - restitution * restitution;
  if (damping_mode == 0) return loss / restitution;
  const double factor = 0.75 * loss;
  return damping_mode == 2 ? factor * std::exp(2.0 * (1.0 - restitution)) : factor;
}

/// Hysteretic law (eq. 8-16), F = h u^1.5 (1 + D v / v_impact). radius = 2 R1 R2 / (R1 + R2), or 2 R1 against a wall.
/// impact_speed is the closing speed when the contact formed; 0 for a contact that was there when the law was switched
/// on. Where impact_speed is too small, the dashpot is held at limit x critical damping of the tangent stiffness; the
/// total never pulls.
inline NormalResponse hysteretic_normal(double overlap, double closing_speed, double impact_speed, double mass,
                                        double radius, double shear_modulus, double poisson_ratio, double damping,
                                        double limit) {
  const double contact_size = shear_modulus * std::sqrt(2.0 * radius * overlap);
  const double elastic = 2.0 * contact_size * overlap / (3.0 * (1.0 - poisson_ratio));
  const double shear_stiffness = 2.0 * contact_size / (2.0 - poisson_ratio);
  const double tangent_stiffness = contact_size / (1.0 - poisson_ratio);
  const double highest = limit * 2.0 * std::sqrt(mass * tangent_stiffness);
  const bool at_limit = damping * elastic >= highest * impact_speed;
  const double coefficient = at_limit ? highest : damping * elastic / impact_speed;
  const double damped = elastic + coefficient * closing_speed;
  const double total = damping == 0.0 ? elastic : (damped > 0.0 ? damped : 0.0);
  return {elastic, total, shear_stiffness, at_limit && damping != 0.0 ? 1.0 : 0.0};
}

/// A contact is new if it was touched neither in this step nor in the one before. The history of a pair is not cleared
/// when it separates, and steps are counted on through a restart, so that this holds everywhere. 0 is a history that
/// was never written: a contact that closes in step 1 is new as well.
inline bool is_new_contact(double last_touch_step, double step) {
  return last_touch_step == 0.0 || (last_touch_step != step && last_touch_step != step - 1.0);
}

/// Share of a closing step during which the surfaces touched (eq. 3): overlap / (overlap - overlap one step ago).
inline double touching_share(double overlap, double closing_speed, double time_step) {
  const double approach = closing_speed * time_step;
  return approach > overlap ? overlap / approach : 1.0;
}

/// True where a contact without history is deeper than a step's approach explains: it existed before the law was
/// switched on.
inline bool existed_before(double overlap, double closing_speed, double time_step) {
  return overlap > 2.0 * closing_speed * time_step;
}

}  // namespace ballast

#endif
