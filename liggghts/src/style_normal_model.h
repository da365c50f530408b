#include "normal_model_ballast_linear.h"
#include "normal_model_ballast_hysteretic.h"
