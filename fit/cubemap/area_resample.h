// Mean radiance over the footprint of a cubemap texel, from exact overlaps of areas on the sphere. Internal to fit/cubemap.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "formats/environment.h"

namespace lightcook::fit {

class AreaResampler {
public:
    /// The environment must outlive this.
    explicit AreaResampler(const formats::Environment& environment);
    /// Returns the mean over texel (x, y) of a face of size x size texels; size a power of two.
    glm::dvec3 mean(int face, int x, int y, int size) const;

private:
    struct Sum {
        glm::dvec3 flux{0};
        double solidAngle = 0;
    };
    glm::dvec3 meanFromStrip(int face, int x, int y, int size) const;
    void addSideFace(double psiOfFace, glm::dvec2 low, glm::dvec2 high, Sum& sum) const;
    void addPolarFace(bool north, glm::dvec2 low, glm::dvec2 high, Sum& sum) const;
    void addMeridian(double psi, double weight, double yLow, double yHigh, Sum& sum) const;
    template <class Interval>
    void integrateAzimuth(double begin, double end, const Interval& intervalAt, Sum& sum) const;

    const formats::Environment& environment_;
    std::vector<double> rowEdges_;  ///< y = cos(theta) of the panorama's row edges, from 1 down to -1
};

}  // namespace lightcook::fit
