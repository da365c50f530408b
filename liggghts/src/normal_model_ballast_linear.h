#ifdef NORMAL_MODEL
NORMAL_MODEL(BALLAST_LINEAR, ballast/linear, 40)
#else
#ifndef NORMAL_MODEL_BALLAST_LINEAR_H_
#define NORMAL_MODEL_BALLAST_LINEAR_H_

#include "contact_laws.h"
#include "contact_models.h"
#include "normal_model_base.h"
#include "property_access.h"

namespace LIGGGHTS {
namespace ContactModels {

/// `model ballast/linear`: the paper's linear contact law (eq. 1-7).
template <>
class NormalModel<BALLAST_LINEAR> : public NormalModelBase {
 public:
  NormalModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *model)
      : NormalModelBase(lmp, setup, model), normal_stiffness_(NULL), shear_stiffness_(NULL), damping_ratio_(NULL) {
    model->add_history_offset("last_touch_step", setup->add_history_value("last_touch_step", "0"));
  }

  void registerSettings(Settings &) {}
  void postSettings(IContactHistorySetup *, ContactModelBase *) {}

  void connectToProperties(PropertyRegistry &registry) {
    ballast::connect_pair_property<&ballast::NORMAL_STIFFNESS>(registry, normal_stiffness_, "ballast/linear");
    ballast::connect_pair_property<&ballast::SHEAR_STIFFNESS>(registry, shear_stiffness_, "ballast/linear");
    ballast::connect_pair_property<&ballast::DAMPING_RATIO>(registry, damping_ratio_, "ballast/linear");
  }

  double stressStrainExponent() { return 1.0; }

  inline void surfacesIntersect(SurfacesIntersectData &contact, ForceData &on_i, ForceData &on_j) {
    if (contact.contact_flags) *contact.contact_flags |= CONTACT_NORMAL_MODEL;
    const int a = contact.itype, b = contact.jtype;
    const ballast::NormalResponse response = ballast::linear_normal(
        contact.deltan, -contact.vn, contact.meff, normal_stiffness_[a][b], shear_stiffness_[a][b], damping_ratio_[a][b]);
    contact.Fn = response.elastic_force;
    contact.kt = response.shear_stiffness;
    contact.gamman = 0.0;
    for (int d = 0; d < 3; d++) {
      on_i.delta_F[d] += response.total_force * contact.en[d];
      on_j.delta_F[d] -= response.total_force * contact.en[d];
    }
  }

  void surfacesClose(SurfacesCloseData &, ForceData &, ForceData &) {}
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

 private:
  double **normal_stiffness_, **shear_stiffness_, **damping_ratio_;
};

}  // namespace ContactModels
}  // namespace LIGGGHTS

#endif
#endif
