#pragma once
#include "casefile/build/build_problem.hpp"
#include "casefile/build/region_ground.hpp"
#include "core/planform/find_wings.hpp"
#include "optimize/space/twist.hpp"

#include <map>
#include <memory>

/// From the checked case to the problem, topic by topic. Between the builder's files; not for others.
namespace strake {

struct ShellSetup;
struct Wrap;
struct FieldConditions;
struct ProgramPoints;
struct StoredDesign;
class WingCoordinates;

class ProblemBuilder {
public:
    ProblemBuilder(const Case& the_case, Purpose purpose)
        : case_(the_case), purpose_(purpose), errors_(diagnostics_of(the_case)) {}
    BuiltProblem build();
    RegionGround ground();

private:
    const Case& case_;
    Purpose purpose_;
    Diagnostics errors_;
    bool wants_patches_ = false;  ///< though no region names one yet
    StartSurface start_;
    std::optional<StartSurface> wrap_;  ///< what is elastic in its place
    std::vector<int> wrap_triangle_;    ///< with a wrap, per triangle of `start_` the nearest of the wrap
    PatchHierarchy start_tree_;         ///< with a wrap: the tree on `start_`
    BuiltProblem out_;
    std::map<std::string, int> region_index_;
    std::shared_ptr<const StoredDesign> stored_;  ///< that `start_from` names
    std::vector<std::pair<TwistSpec, Place>> twists_;
    std::map<std::string, std::shared_ptr<const Wing>> wings_;
    std::map<std::string, std::shared_ptr<const Fuselage>> bodies_;
    std::optional<std::optional<SymmetryPlane>> plane_;  ///< of `start_`, once it was looked for

    /// Runs `work`; what it refuses becomes an error at `place`.
    template <class Work>
    void at(const Place& place, const std::string& prefix, const Work& work) {
        try {
            work();
        } catch (const InvalidInput& e) {
            errors_.add(place, prefix + e.what());
        }
    }
    const std::vector<int>& triangles(const Reference& region) const {
        return out_.regions[region_index_.at(region.name)].triangles;
    }
    /// What the shell stands on: the wrap, or else the surface.
    const StartSurface& elastic() const { return wrap_ ? *wrap_ : start_; }
    /// The tree with its patches on the surface.
    const PatchHierarchy& tree_on_surface() const { return wrap_ ? start_tree_ : out_.problem.tree; }

    // build_surface.cpp
    void read_start();
    const std::optional<SymmetryPlane>& start_plane();  ///< `plane_of_symmetry` of the surface
    void check_symmetry_plane();
    Split split();
    void build_tree();
    PatchHierarchy whole_surface() const;
    void read_stored();
    void read_designs();
    void evaluate_regions();
    // build_wrap.cpp
    void make_wrap();
    void note_wrap(const Wrap& wrap);
    void set_wrap();
    void hold_wrap();
    std::vector<int> elastic_triangles(const Reference& region) const;
    const std::vector<int>& held_triangles() const;
    /// Motions hold what they move; fields leave it to them. Triangles of `start_`.
    void leave_to_motion(const std::vector<int>& where);
    void leave_frozen();
    // build_shell.cpp
    void set_heights();
    void check_heights(const Eigen::VectorXd& height);
    void set_pins();
    PrescribedStrain prescribed(const StrainEntry& strain, const std::vector<char>& is_fixed) const;
    void check_strain(const StrainEntry& strain, const std::vector<char>& is_fixed,
                      std::vector<const StrainEntry*>& owner);
    /// @param shown what is said to leave the plane: "strains: region 'x'".
    void check_symmetry(const Place& place, const std::string& shown, const PrescribedStrain& given);
    void warn_shared_vertices(const StrainEntry& strain, const std::vector<int>& held,
                              const std::vector<char>& is_fixed);
    // build_attach.cpp
    void set_attached();
    std::vector<int> part_triangles(const Reference& reference);
    void check_loaded();
    // build_loads.cpp
    std::vector<char> loaded_by_variables() const;
    void set_springs();
    void set_tractions();
    void make_shell(std::optional<PrimoShell>& shell, ShellSetup& setup);
    Eigen::Vector3d scaled_traction(const LoadEntry& load, PrimoShell& shell, const ShellSetup& setup);
    // build_parameters.cpp
    void set_parameters();
    void set_motion_limits();
    void set_planform();
    void set_kept_sections();
    void check_dof();
    bool keeps_edges() const;
    void set_fields();  // build_fields.cpp
    struct FieldsOfWing {
        std::shared_ptr<const WingCoordinates> wing;  ///< null: fields are not those of a wing
        bool keeps_planform = false;
    };
    bool wants_fields_of_wing() const;
    FieldsOfWing fields_of_wing(FieldConditions& conditions);
    FieldsOfWing chosen_fields_of_wing(FieldConditions& conditions);
    std::optional<FoundWing> wing_seen() const;
    void set_invariance();
    void set_hold();
    void check_hold();
    int support_near(const std::vector<int>& part) const;
    /// Per triangle: lies in one of these regions or patches; empty without names.
    std::vector<char> marked(const std::string& key, const std::vector<Reference>& names);
    std::vector<char> marked_on_surface(const std::string& key, const std::vector<Reference>& names);
    /// Of the elastic surface, and of the surface.
    std::vector<int> region_or_patch(const std::string& key, const Reference& reference);
    std::vector<int> region_or_patch_on_surface(const std::string& key, const Reference& reference);
    // build_user_variables.cpp
    void set_user_values();
    void set_twists();
    UserVariable user_load(const UserVariableEntry& entry, const std::vector<int>& where) const;
    UserVariable user_motion(const UserVariableEntry& entry, const std::vector<int>& where);
    bool may_be_user_defined(const UserVariableEntry& entry, const std::vector<int>& where);
    // build_goals.cpp
    void set_goals();
    void set_cheap_models();
    Quantity make_program(const QuantityEntry& entry, const ExternalEntry& program, const char* folders);
    Quantity make(const QuantityEntry& entry, const VolumeEntry& what);
    Quantity make(const QuantityEntry& entry, const AreaEntry& what);
    Quantity make(const QuantityEntry& entry, const TargetShapeEntry& target);
    Quantity make(const QuantityEntry& entry, const MeasuredPointsEntry& measured);
    Quantity make(const QuantityEntry& entry, const LineThicknessEntry& along);
    Quantity make(const QuantityEntry& entry, const SectionAreaEntry& area);
    Quantity make(const QuantityEntry& entry, const ExternalEntry& program);
    Quantity make(const QuantityEntry& entry, const BuiltInEntry& made);
    Quantity make(const QuantityEntry& entry, const FormulaEntry& formula);
    Quantity make_plugin(const QuantityEntry& entry, const ExternalEntry& program) const;
    std::shared_ptr<const ProgramPoints> program_points(const ExternalEntry& program) const;
};

}  // namespace strake
