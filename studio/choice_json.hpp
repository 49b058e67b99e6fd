#pragma once
#include "studio/choice.hpp"

#include <nlohmann/json.hpp>

namespace strake {

/// Steps as the page sends them: [{op: "+" | "-" | "&", patch: NAME | part: NUMBER | component: NUMBER |
/// flood: {point: [x, y, z], angle: degrees} | plane: {normal: [x, y, z], at: number, above: bool} |
/// box: [[x, y, z], [x, y, z]] | triangles: [number, …] | all: true | grow: length | invert: true |
/// wing: {of: NAME or "", chord: [from, to], span: [from, to], side: both | upper | lower} | region: NAME}].
/// @throws InvalidInput: anything else, numbers that are not finite, a box inside out, a normal of length 0.
std::vector<ChoiceStep> choice_steps(const nlohmann::json& steps, const TriMesh& mesh);

}  // namespace strake
