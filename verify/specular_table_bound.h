// What the error of the tables cannot exceed at any view and roughness of their range, also between the places that were looked at.
//
// A cell of a table is cut into small ones. Inside a small one the table is bilinear in its axes, so its error differs from the bilinear
// blend of the four corners' errors by no more than the kernel T differs from the blend of its own corners:
//
// - over roughness: |d2T/dm2| <= K sup|w Y| / m^2, since only the density of slopes depends on m (K = 4.218 Beckmann, 1.736 GGX, the mean
//   of |second derivative / density|);
// - over the view: T(x) - chord <= (D - d) width / 4 for a derivative that is inside [d, D]. The derivative is enclosed by intervals over
//   boxes of half vectors: w is a maximum of minima of lines in u (lighting/area_specular.h), Y of a mirrored direction turns no faster
//   than its band lets it, and each box weighs what the distribution has in it, which is a closed form.
//
// Kernels at corners are taken as exact: they are, to 1e-7. Filters have exact fractions (as verify/texture_unit.h).
#pragma once

#include <vector>

#include "verify/specular_tables.h"

namespace lightcook::verify {

struct SpecularTableCellBound {
    SpecularKernelEntries entries{};  ///< largest absolute error of each entry in the cell
    double filter = 0;                ///< largest local relative error of an entry
    double total = 0;                 ///< of a shading
};

/// The cells between view nodes viewCell and viewCell + 1, one for each pair of roughness nodes (one in all for a table of one row). Pure,
/// safe on several threads. All bounds are infinite where coordinates of the axes do not meet their texels.
std::vector<SpecularTableCellBound> boundSpecularTables(const CookedSpecularTables& tables, int viewCell, const SpecularTableKeys& keys,
                                                        const std::vector<double>& f0);
/// All cells, on the calling thread.
SpecularTableBounds boundSpecularTables(const CookedSpecularTables& tables, const SpecularTableKeys& keys, const std::vector<double>& f0);
SpecularTableBounds largestOf(const CookedSpecularTables& tables, int viewCell, const std::vector<SpecularTableCellBound>& cells);

}  // namespace lightcook::verify
