"""The mutations of tools/mutate.py: lines of the engine that must not be wrong, and the tests that should notice if they are.

A line is an expression, or a statement if it ends with `;`; it must occur exactly once under its folder. `instead` takes its
place. A test is EXECUTABLE or EXECUTABLE:FILTER (a GoogleTest filter).
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    name: str
    under: str
    line: str
    instead: str
    tests: tuple


def of(name, under, line, instead, *tests):
    return Mutation(name, under, line, instead, tests)


GRID, ADAPT, DELTA = "proto_test:*Grid*", "proto_test:*Adaptation*:MotionMargin*", "proto_test:DeltaCodec*"
BOUNDS = "terrain_threads_test"
FLIGHT = "world_test:World.ErrorInEveryFrame*:*EveryStrategy*"

MUTATIONS = [
    # topology
    of("diagonal: sign", "proto/topology/grid", "result.push(NodeId::at(x - s, y + up));", "result.push(NodeId::at(x - s, y - up));", GRID),
    of("data: off by one", "proto/topology/grid", "n.x() - s < shape_.samples_x - 1", "n.x() - s <= shape_.samples_x - 1", GRID),
    of("seam: turned the other way", "proto/topology/cube", "other.x - quarters * dy", "other.x + quarters * dy", "proto_test:*CubeGrid*"),
    of("seam: a page like any other", "proto/refine/page_neighbours", "place.y == last", "false", "proto_test:PageTopology*"),
    of("seam: a triangle's number", "client/mesh/terrain", "level % 2 == 0 ? kOfCentre[i] : kOfSide[i]", "kOfSide[i]", "client_test:MeshPatches*"),
    of("horizon: region ignored", "proto/refine/metric/horizon", "floor - stretch_ * view.region_radius_m", "floor", "proto_test:GlobeHorizon*"),
    of("horizon: slack too long", "proto/refine/metric/horizon", "std::min(widest_, until_cone)", "widest_", "proto_test:GlobeHorizon*"),
    # bounds
    of("error: rounded down", "proto/section", "(eighths + kEach - 1) / kEach + 1", "(eighths + kEach - 1) / kEach",
       "proto_test:QuantisedError*"),
    of("saturation: children dropped", "terrain/bounds",
       "proto::QuantisedError{band.child_errors[i]}", "proto::QuantisedError{}", BOUNDS),
    of("sphere: of the page's last", "terrain/bounds", "std::max(most, r.radius())", "r.radius()", BOUNDS),
    of("sphere: children's radii", "terrain/bounds", "std::sqrt(dx * dx + dy * dy + dz * dz) + child.radius[i]",
       "std::sqrt(dx * dx + dy * dy + dz * dz)", BOUNDS),
    of("error: tail of a row", "terrain/bounds", "std::fabs(samples[i] - (value + slope * i))", "0.0", BOUNDS),
    of("sparse: corners beyond the children", "terrain/bounds", "if (!has_all) {", "if (false) {", BOUNDS),
    of("sparse: beyond the border", "terrain/bounds", "if (!isData(v->id)) planes_.measure(v->id, v->value);", ";", BOUNDS),
    of("sparse: planes of one walk alone", "terrain/bounds/sparse_errors", "pushHolders(glm::dvec2(a + b + apex) / 3.0, level);", ";", BOUNDS),
    of("sparse: parents left out", "proto/section/page_directory", "addParentPages(grid, level, *page, pages);", ";", BOUNDS, "proto_test:*Directories*"),
    # the test and its slack
    of("frustum: sign", "proto/refine/metric", "is_visible & (frustum_.sideDistance(p) + R >= 0)", "is_visible & (frustum_.sideDistance(p) - R >= 0)",
       "proto_test:MotionMargin*", FLIGHT),
    of("region: radius ignored", "proto/refine/metric/metric", "view.region_radius_m", "0.0", FLIGHT, "protocol_test"),
    of("region: angle ignored", "proto/refine/metric/frustum", "std::min(view.region_angle_rad, 1.5)", "0.0", FLIGHT, "protocol_test"),
    of("slack: side planes ignored", "proto/refine/metric/motion_margin", "passed ? std::min(visible_margin, n.side_margin) : -visible_margin",
       "passed ? visible_margin : -visible_margin", ADAPT),
    of("slack: too long", "proto/refine", "result.slack * kSlackShare", "result.slack * 4", ADAPT),
    of("motion: turning ignored", "proto/refine/metric/motion_margin", "set(Sensitivity::kMotion, moved + region, turned + scaled);",
       "set(Sensitivity::kMotion, moved + region, scaled);", ADAPT),
    of("motion: sides ignored", "proto/refine/metric/motion_margin",
       "std::max(least, frustum.sideApproach(seen, moved))", "least", ADAPT),
    of("motion: aside ignored", "proto/refine/metric/motion_margin", "ahead + std::fabs(move.z) + kAdvanceStray * (aside + rising + region)",
       "ahead + std::fabs(move.z)", ADAPT),
    of("slack: distance ignored", "proto/refine", "_mm256_mul_ps(_mm256_permutevar_ps(per_distance, sensitivity), max_distance)",
       "_mm256_setzero_ps()", ADAPT),
    of("constraint: rounded down", "proto/refine", "(std::bit_cast<uint32_t>(max_distance_m) + 0x1ffff)", "std::bit_cast<uint32_t>(max_distance_m)",
       "proto_test:MotionConstraint*"),
    # the step
    of("removal: closure dropped", "proto/refine/node_changes", "inner.add(low, hasChildInSection(nodes.at(low), level));", "inner.add(low, false);",
       "proto_test:PageChanges*"),
    of("addition: parents stay removable", "proto/refine/node_changes",
       "for (NodeId parent : topology_.parents(n, level)) leave(topology_.slot(parent, level - 1));", ";", "proto_test:PageChanges*"),
    of("pages: next column dropped", "proto/refine/page_neighbours", "gatherEven(rows | next_rows | rows >> 1 | next_columns)",
       "gatherEven(rows | next_rows | rows >> 1)", "proto_test:PageTopology*"),
    of("pages: border forgotten", "proto/refine/page_neighbours", "row == 0 && p.y == 0 ? 0xffffu : 0", "0u", "proto_test:PageTopology*"),
    of("sweep: any error, no tolerance", "proto/refine/sweep", "tolerance + k.of_error * K", "0.0f", "proto_test:Sweep*"),
    of("sweep: nearly beside a plane, too little", "proto/refine/sweep", "(beside2 * 16 < d2 ? k.of_side + k.of_steep : k.of_side)", "k.of_side",
       "proto_test:Sweep*"),
    of("sweep: unknown heights", "proto/refine/sweep", "((is_in_section & fails) | (~is_in_section & passes)) & is_known",
       "(is_in_section & fails) | (~is_in_section & passes)", "proto_test:Sweep*"),
    of("sweep: hidden entries never tested", "proto/refine/sweep", "~(is_hidden & leave)", "~is_hidden", "proto_test:Sweep*"),
    of("sweep: packed bytes out of order", "proto/refine/sweep", "_mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7)",
       "_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)", "proto_test:Sweep*"),
    of("bound: off by one", "proto/refine", "(c.in_section[i] != 0 ? 0 : 1)", "0", ADAPT, DELTA),
    # the codec
    of("height: prediction", "proto/codec", "3 * curve()", "2 * curve()", DELTA),
    of("decision: context", "proto/codec", "(2 * before_ + (got ? 1 : 0)) & 3", "(2 * before_ + (got ? 1 : 0)) & 1", DELTA),
    of("height: displacement", "proto/section/bounds.h", "height - middle(), {}, radius()", "height, {}, radius()", DELTA),
    of("refusals: of all", "proto/codec/delta_codec", "any |= is_rejected & decisions[end];", "any |= 0;", DELTA),
    of("section: closure dropped", "proto/codec/section_codec", "(has_all ? page.candidates : page.half).set(low);",
       "page.candidates.set(low);", "proto_test:HeldSectionsCodec*"),
    of("object: frontier", "proto/codec/surface_cut", "if (!hasChild(parent, level - 1)) addToFrontier(mesh_->slot(parent, level - 1));",
       "addToFrontier(mesh_->slot(parent, level - 1));", "proto_test:*SurfaceCodec*"),
    # what is remembered
    of("memory: the oldest is presented first", "proto/refine/memory/node_memory", "std::reverse(pages.begin(), pages.end());", ";", "proto_test:NodeMemory*"),
    of("memory: budget ignored", "proto/refine/memory/node_memory", "client_bytes_ > budget_", "false", "proto_test:NodeMemory*"),
    of("memory: finest question forgotten", "proto/refine/terrain_tester", "std::max(kMinError, nodes.page(c.page[i]).knowledge.finest)", "kMinError",
       "proto_test:*Predicates*"),
    of("memory: decisions not noted", "proto/refine/terrain_tester", "frontier.noteDecision(c.page[i], least);", ";", "proto_test:*Predicates*"),
    of("memory: settled too early", "proto/refine/terrain_tester", "low != high", "false", "proto_test:*Predicates*"),
    of("memory: finest question not presented", "proto/codec/section_codec", "page.knowledge.finest = given->knowledge.finest;", ";", "proto_test:SectionCodec*"),
    of("epochs: both ends at one time", "client/mesh/terrain/end_heights", "offsets_->at(weights_[end], v)", "offsets_->at(weights_[1], v)",
       "client_test"),
    of("epochs: passed unshown", "server/session", "epochs.towards(from, wanted)", "wanted", "world_test:SceneTime*"),
    of("epochs: errors of the first alone", "terrain/bounds", "job_.min_errors.empty()", "true", "terrain_test"),
    of("epochs: spheres of the first alone", "terrain/bounds", "corners(samples, row, radii_m, child_errors);", ";",
       "terrain_test"),
    of("epochs: known after a resumption", "proto/codec/epoch_stream", "offsets_.forget();", ";", "world_test:MovingGroundLost*"),
    of("orders: knots", "oracle/reference/order_blend", "u + order - 1 - static_cast<double>(i)", "u + order - static_cast<double>(i)",
       "oracle_test:Basis*"),
    # the server
    of("fingerprint: removals", "server/section", "proto::fingerprint(scratch.delta.added) - proto::fingerprint(scratch.delta.removed)",
       "proto::fingerprint(scratch.delta.added)", FLIGHT),
    of("acknowledgement: off by one", "server/session", "update.received_keyframe > keyframe().index",
       "update.received_keyframe > keyframe().index + 1", "server_test"),
    of("region: half the interval", "server/view/region", "growth.advanceTo(timeBetween(begin, end, i, steps));",
       "growth.advanceTo(timeBetween(begin, end, i, 2 * steps));", FLIGHT),
    of("deadline: an interval late", "server/session", "clocks.sendBy(t - state.leadTime(state.interval))", "clocks.sendBy(t)", FLIGHT),
    of("budget: sign", "server/section", "std::log(triangles_ / (kMiddle * budget.triangles))", "-std::log(triangles_ / (kMiddle * budget.triangles))",
       "server_test:ToleranceControl*"),
    # the client
    of("resumption: refused", "server/session", "resume.scene_id != hierarchy.scene().id()", "true", "world_test:*Faults*"),
    of("acknowledgements: never waited for", "server/session", "in_flight_.size() >= options_.max_unacknowledged", "false", "world_test:*Faults*"),
    of("timeline: jump", "client", "begin = std::max(begin, schedule_.back().end);", ";", "client_test:*Timeline*", "world_test:World.Strategies*"),
    of("blend: weight", "client", "weight * displacement()", "(1 - weight) * displacement()", "world_test:*Geomorph*"),
    of("mesh: crack at the border", "oracle/reference", "from + u * (to - from)", "from + 0.9 * u * (to - from)", "oracle_test:MeshAtTheBorder*"),
    of("mesh: first blends from nothing", "client", "span_.is_first ? 0 : 1", "1", "client_test:MorphTiming*"),
    of("object: both ends alike", "oracle/reference/object_mesh", "weight[s]", "weight[1]", "world_test:Objects.AreDrawn*"),
    of("poses: both ends alike", "client/mesh/objects/object_positions", "proto::posed(position, stream.moves(object, slot), weights[end])",
       "proto::posed(position, stream.moves(object, slot), weights[0])",
       "world_test:MovingGroundWithObjects*"),
    of("poses: only the first bounded", "terrain/surface/bounds", "pose < displacements_.size()", "pose < 1", "terrain_threads_test:*Mix*"),
    of("solid: only the full mesh kept out", "terrain/surface/inner_solids", "std::max(0.0, glm::dot(direction, displacement))",
       "glm::dot(direction, displacement)", "terrain_test:FindSolids*"),
    of("solid: winding ignored", "terrain/surface/inner_solids", "std::fabs(windingNumber(mesh, shape.middle) - 1) < 1e-3", "true",
       "terrain_test:IsInside*"),
    of("solid: for four fifths of the eyes", "server/occlusion/objects/object_solids", "- eyes.radius_m - kDepthRounding_m", "- 0.8 * eyes.radius_m",
       "server_test:ObjectSolids*"),
    of("solid: of an object with poses", "server/occlusion/objects/object_solids", "!objects.set.modelOf(object).pose_epochs.empty()", "false",
       "server_test:ObjectSolids*"),
    of("solid: of an object that ground carries", "server/occlusion/objects/object_solids", "!placement.rise.isStill() || ", "",
       "server_test:ObjectSolids*"),
    of("morph: off by one", "client", "m.from + left / steps", "m.from + left / (steps + 1)", "client_test"),
    of("morph: region ignored", "client", "radius_m + region_radius_", "radius_m - region_radius_", "client_test"),
]
