#include "pipeline/report/limit_use.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {
namespace {

/// Collects the use that is the largest share of its limit.
class MostUsed {
public:
    void addPercent(const std::string& name, const Json& object, const char* key, const Json& limit) {
        if (takes(object, key, limit))
            use_->words = fmt::format("{} {} of {}", name, humanPercent(number(member(object, key))), humanPercent(number(limit)));
    }
    void addVisible(const std::string& name, const Json& object, const char* key, const Json& limit) {
        if (!takes(object, key, limit)) return;
        const double value = number(member(object, key));
        use_->words =
            fmt::format("{} {} of {:.3g}", name, std::isfinite(value) ? fmt::format("{:.2f}", value) : "not finite", number(limit));
    }
    [[nodiscard]] const std::optional<LimitUse>& use() const { return use_; }

private:
    /// Takes a figure if it uses more of its limit than those before. Returns false if not, or without figure or limit.
    bool takes(const Json& object, const char* key, const Json& limit) {
        const double value = number(member(object, key)), most = number(limit);
        if (!(most >= 0) || !object.is_object() || !object.contains(key)) return false;
        const double share = value == 0 ? 0 : std::isfinite(value) && most > 0 ? value / most : std::numeric_limits<double>::infinity();
        if (use_ && share <= use_->share) return false;
        use_ = {share, ""};
        return true;
    }

    std::optional<LimitUse> use_;
};

/// Adds the figures of a stage: those of the last one, or of a mip level.
/// where  before the name of a figure: "" or "mip 1 "
void addStage(const Json& stage, const std::string& where, const Json& limit, MostUsed& most) {
    for (const char* shading : kShadings) {
        const Json &figures = member(member(stage, "error"), shading), &visible = member(figures, "visible");
        most.addPercent(where + "rel_rms", figures, "rel_rms", member(limit, "value"));
        most.addVisible(where + "visible p99", visible, "p99", member(limit, "max_visible"));
        most.addVisible(where + "visible bound", visible, "bound", member(limit, "max_visible_bound"));
    }
}

void addSeam(const char* name, const Json& seams, const Json& limit, MostUsed& most) {
    const Json& worst = list(seams, "worst");
    if (!worst.empty()) most.addVisible(name, worst[0], "added", limit);
}

}  // namespace

std::optional<LimitUse> mostUsedLimit(const Json& asset) {
    const Json &limit = member(asset, "limit"), &whole = member(asset, "whole"), &split = member(asset, "split_seams");
    MostUsed most;
    addStage(lastStage(asset), "", limit, most);
    for (const char* levels : {"mips", "mip_blends"})
        for (const Json& mip : list(asset, levels)) addStage(mip, words(member(mip, "name")) + " ", limit, most);
    addSeam("seam", member(asset, "seams"), member(limit, "max_seam"), most);
    addSeam("seam between maps", split, member(split, "max_seam"), most);
    most.addVisible("visible p99 with its dominant light", member(whole, "visible"), "p99", member(whole, "max_visible"));
    most.addPercent("rel_rms with its dominant light", whole, "rel_rms", member(whole, "max_error"));
    return most.use();
}

}  // namespace lightcook::pipeline
