#pragma once
#include "casefile/build/region_ground.hpp"
#include "core/planform/wing.hpp"
#include "studio/case_text.hpp"

#include <filesystem>
#include <variant>

/// Triangles chosen step by step, and the shortest words of a case file that mean the same triangles.
namespace strake {

/// How a step changes what was chosen before it.
enum class Combine { add, subtract, intersect };

struct PickedTriangles {
    std::vector<int> triangles;  ///< of the surface in memory
};
struct PickedAll {};
/// Changes of what is chosen, without a shape of their own.
struct GrowChoice {
    double by = 0;  ///< length along edges; negative shrinks
};
struct InvertChoice {};
/// The mirror image comes along: triangles whose middle, mirrored, lies on a chosen one.
struct MirrorChoice {
    SymmetryPlane plane;
};
/// A region that the case declares.
struct DeclaredRegion {
    std::string name;
};

/// A part of a wing by fractions of its chord and semispan: the box between two spars.
struct WingBox {
    std::string wing;  ///< that the case declares; "": the one that was found, which the case does not declare
    std::array<double, 2> chord{0, 1}, span{0, 1};
    int side = 0;  ///< 1: upper, -1: lower, 0: both
};

struct ChoiceStep {
    Combine combine = Combine::add;
    std::variant<PatchShape, SolidShape, ComponentShape, FloodedRegion, HalfSpace, BoxShape, PickedTriangles, PickedAll,
                 GrowChoice, InvertChoice, MirrorChoice, DeclaredRegion, WingBox>
        what;
};

/// What the triangles are chosen on. Shapes are evaluated by the code that evaluates the regions of a case.
struct ChoiceGround {
    const RegionGround& ground;
    const std::vector<Region>& declared;  ///< regions of the case
    std::vector<WingEntry> wings = {};    ///< and wings, which these may be parts of
    BodyAxes axes = {};
    std::optional<SymmetryPlane> symmetry = {};
    const Wing* found_wing = nullptr;  ///< for boxes of a wing that the case does not declare
};

/// Per triangle: chosen by the steps in their order, from nothing.
/// @throws InvalidInput: unknown names, and triangle numbers out of range. A box that holds nothing adds nothing.
std::vector<char> chosen(const ChoiceGround& ground, const std::vector<ChoiceStep>& steps);

struct Description {
    std::vector<RegionText> regions;  ///< the last one is the chosen; those before it are what it is made of
    std::string kind;          ///< "whole surface", "part", "patch", "plane", "box", "patches", "steps", "list", …
    std::vector<int> numbers;  ///< of "list": triangle numbers of the surface file, for the file `list_file`
};

/// The shortest of these that means exactly the marked triangles, each evaluated as the case will evaluate it: the
/// whole surface; one part of the file, connected component or patch; the only step, if it is a plane, box or flood; a
/// half-space or box along the coordinates; a union of parts or of patches; everything but a part, component or
/// patch; up to six steps by name; the list of triangles.
/// @param list_file where the list would stand, as the case names it.
/// @throws InvalidInput: nothing is marked, or only a list would do and the surface was remeshed.
Description described(const ChoiceGround& ground, const std::vector<ChoiceStep>& steps, const std::vector<char>& marks,
                      const std::string& name, const std::string& list_file);

/// "of: wing, chord: [0.15, 0.65], span: [0, 1]".
std::string wing_box_words(const WingBox& box);
/// The shortest decimal number in [low, high], the nearest to zero of several.
std::string shortest_between(double low, double high);
/// Digits that read back as the same number.
std::string exact_words(double value);

}  // namespace strake
