#ifdef NORMAL_MODEL
NORMAL_MODEL(BALLAST_HYSTERETIC, ballast/hysteretic, 41)
#else
#ifndef NORMAL_MODEL_BALLAST_HYSTERETIC_H_
#define NORMAL_MODEL_BALLAST_HYSTERETIC_H_

#include "contact_laws.h"
#include "contact_models.h"
#include "normal_model_base.h"
#include "property_access.h"
#include "stop_with_error.h"
#include "update.h"

namespace LIGGGHTS {
namespace ContactModels {

/// `model ballast/hysteretic`: Hertz spring with the impact-speed dashpot (eq. 8-16).
template <>
class NormalModel<BALLAST_HYSTERETIC> : public NormalModelBase {
 public:
  NormalModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *model)
      : NormalModelBase(lmp, setup, model), shear_modulus_(NULL), poisson_ratio_(NULL), restitution_(NULL), damping_mode_(0),
        last_touch_(setup->add_history_value("last_touch_step", "0")), impact_speed_(setup->add_history_value("impact_speed", "0")) {
    model->add_history_offset("last_touch_step", last_touch_);
  }

  void registerSettings(Settings &) {}
  void postSettings(IContactHistorySetup *, ContactModelBase *) {}

  void connectToProperties(PropertyRegistry &registry) {
    ballast::connect_pair_property<&ballast::SHEAR_MODULUS>(registry, shear_modulus_, "ballast/hysteretic");
    ballast::connect_pair_property<&ballast::POISSON_RATIO>(registry, poisson_ratio_, "ballast/hysteretic");
    ballast::connect_pair_property<&ballast::RESTITUTION>(registry, restitution_, "ballast/hysteretic");
    ballast::connect_scalar_property<&ballast::DAMPING_MODE>(registry, damping_mode_, "ballast/hysteretic");
    const int types = registry.max_type();
    damping_.assign((types + 1) * (types + 1), 0.0);
    types_ = types + 1;
    const int mode = static_cast<int>(damping_mode_);
    if (mode != damping_mode_ || mode < 0 || mode > 2)
      ballast::stop_with_error(lmp, "dampingMode: must be 0, 1 or 2; correct the fix property/global");
    for (int a = 1; a <= types; a++)
      for (int b = 1; b <= types; b++) {
        if (mode == 0 && restitution_[a][b] == 0.0)
          ballast::stop_with_error(lmp, "nominalRestitution: 0 with dampingMode 0 is singular; give a restitution above 0 or another mode");
        damping_[a * types_ + b] = ballast::damping_factor(restitution_[a][b], mode);
      }
  }

  double stressStrainExponent() { return 1.5; }

  inline void surfacesIntersect(SurfacesIntersectData &contact, ForceData &on_i, ForceData &on_j) {
    if (contact.contact_flags) *contact.contact_flags |= CONTACT_NORMAL_MODEL;
    const int a = contact.itype, b = contact.jtype;
    const double damping = damping_[a * types_ + b];
    const double radius =
        contact.is_wall ? 2.0 * contact.radi : 2.0 * contact.radi * contact.radj / (contact.radi + contact.radj);
    const double impact_speed = damping == 0.0 ? 0.0 : impact_speed_of(contact);
    const ballast::NormalResponse response = ballast::hysteretic_normal(
        contact.deltan, -contact.vn, impact_speed, contact.meff, radius, shear_modulus_[a][b], poisson_ratio_[a][b], damping);
    contact.Fn = response.elastic_force;
    contact.kt = response.shear_stiffness;
    contact.gamman = response.dashpot_at_limit;  // no viscous coefficient here: tells the recorder which dashpots are capped
    for (int d = 0; d < 3; d++) {
      on_i.delta_F[d] += response.total_force * contact.en[d];
      on_j.delta_F[d] -= response.total_force * contact.en[d];
    }
  }

  void surfacesClose(SurfacesCloseData &, ForceData &, ForceData &) {}
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

 private:
  /// Closing speed when the contact formed, m/s; 0 if it was there before the law.
  double impact_speed_of(const SurfacesIntersectData &contact) const {
    double *history = contact.contact_history;
    if (!ballast::is_new_contact(history[last_touch_], static_cast<double>(update->ntimestep))) return history[impact_speed_];
    const double speed = ballast::existed_before(contact.deltan, -contact.vn, update->dt) ? 0.0 : -contact.vn;
    if (contact.computeflag && contact.shearupdate) history[impact_speed_] = speed;
    return speed;
  }

  double **shear_modulus_, **poisson_ratio_, **restitution_;
  double damping_mode_;
  std::vector<double> damping_;  // factor D of every pair of types
  int types_;
  int last_touch_, impact_speed_;
};

}  // namespace ContactModels
}  // namespace LIGGGHTS

#endif
#endif
