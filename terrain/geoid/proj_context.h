// PROJ's objects as owners. A context belongs to one thread at a time; PROJ's messages never reach the terminal, and it
// opens no connection.
#pragma once

#include <proj.h>
#include <proj_experimental.h>  // of it: two dimensions of three, units, pairs

#include <memory>
#include <string>

namespace foreland::terrain {

struct DestroyContext {
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct DestroyProj {
  void operator()(PJ* object) const { proj_destroy(object); }
};
using ProjContext = std::unique_ptr<PJ_CONTEXT, DestroyContext>;
using ProjObject = std::unique_ptr<PJ, DestroyProj>;

ProjContext newProjContext();

// What PROJ last said of an error; empty if nothing.
std::string lastError(PJ_CONTEXT* context);

}  // namespace foreland::terrain
