#pragma once

#include <string>

#include "samara/motion/database/motion_graph.h"

namespace samara::motion {

/// What a database holds: segments by kind, the curve from which the graph's threshold was chosen, and the chain of
/// kinds with its order, as a few lines.
std::string database_text(const MotionDatabase& database, const MotionGraph& graph, const KindChain& kinds);

/// The same as one JSON object, schema "samara-motions/1". Probabilities are those of the chain of first order.
std::string database_json(const MotionDatabase& database, const MotionGraph& graph, const KindChain& kinds);

}  // namespace samara::motion
