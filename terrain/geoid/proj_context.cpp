#include "terrain/geoid/proj_context.h"

namespace foreland::terrain {

ProjContext newProjContext() {
  ProjContext context(proj_context_create());
  proj_log_func(context.get(), nullptr, [](void*, int, const char*) {});
  proj_log_level(context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

std::string lastError(PJ_CONTEXT* context) {
  const int code = proj_context_errno(context);
  return code == 0 ? "" : proj_context_errno_string(context, code);
}

}  // namespace foreland::terrain
