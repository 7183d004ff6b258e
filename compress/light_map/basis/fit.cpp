#include "compress/light_map/basis/fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_solver.h"
#include "compress/light_map/rows.h"
#include "compress/texel/half.h"

namespace lightcook::compress {

namespace {

using formats::Image;

constexpr std::size_t kCount = lighting::kShCount;
/// Standard deviation of what block compression does to a code, about.
constexpr double kCodeNoise = 0.006;
/// Times that the sample goes through the block encoder and the decode is fitted to it.
constexpr int kEncodeRounds = 2;
constexpr std::size_t kSeeds = 16;  ///< of each of two kinds
/// Rounds of "decode for these codes, codes for this decode".
constexpr int kRounds = 6;
/// Codes start this many to a standard deviation, in a box of [0, 1].
constexpr float kDeviationsAcross = 12;
/// Beyond this many standard deviations a code is clamped: a few texels do not spread everyone's steps.
constexpr float kRangeDeviations = 6;

float toHalf(double value) {
    return floatFromHalf(halfFromFloat(static_cast<float>(value)));
}

/// A covered texel of the sample.
struct Texel {
    int x, y;  ///< in the sample's images
    int cluster = 0;
    float weight = 0;
    std::array<float, 3> light{};  ///< squared decoded coefficient 0
    ByChannel ratio{};             ///< what is still to be coded, over the decoded coefficient 0
    std::size_t metric = 0;
    glm::vec4 code{0.5f, 0.5f, 0.5f, 1};
};

class BasisFitter {
public:
    BasisFitter(const LightMapPlan& plan, const BasisShape& shape, const LightMapSamples& samples, const EncodeOptions& options)
        : plan_(plan), samples_(samples), options_(options) {
        model_.shape = shape;
        source_ = sourceOf(plan, samples);
    }

    BasisModel run(const std::vector<int>& charts, int blocksAcross, int clusterCount) {
        model_.blocksAcross = blocksAcross;
        collect();
        weighSquaresToo();
        cluster(charts, clusterCount);
        startCodes();
        for (int round = 0; round < kRounds; ++round) {
            fitDecode();
            solveCodes();
        }
        stretchCodes();
        fitDecode();
        solveCodes();
        encodeCodes();
        for (int layer = 0; layer < model_.shape.residualLayers; ++layer) addResidualLayer();
        return std::move(model_);
    }

private:
    /// The chosen blocks side by side, padded as they are in the map. Some at a time, since what surrounds them takes three times their
    /// room.
    static rows::Source sourceOf(const LightMapPlan& plan, const LightMapSamples& samples) {
        constexpr int kAtATime = 256;
        const int count = static_cast<int>(samples.choices().size());
        rows::Source all;
        all.width = count * kChartBlock;
        all.height = kChartBlock;
        all.coverage = Image<float>(all.width, all.height);
        all.importance = Image<float>(all.width, all.height);
        all.owner = Image<glm::ivec2>(all.width, all.height);
        for (int first = 0; first < count; first += kAtATime) {
            const int end = std::min(first + kAtATime, count);
            LightMapPlan part = plan;
            part.width = (end - first) * LightMapSamples::kSide;
            part.height = LightMapSamples::kSide;
            rows::Source wide =
                rows::makeSource(part, columnsOf(samples.texels(), first * LightMapSamples::kSide, part.width), 0, part.height);
            for (glm::ivec2& owner : wide.owner.texels()) owner.x += first * LightMapSamples::kSide;
            while (all.values.size() < wide.values.size()) all.values.emplace_back(all.width, all.height);
            for (std::size_t i = 0; i < wide.values.size(); ++i) copyBlocks(wide.values[i], all.values[i], first);
            copyBlocks(wide.coverage, all.coverage, first);
            copyBlocks(wide.importance, all.importance, first);
            copyBlocks(wide.owner, all.owner, first);
        }
        return all;
    }
    template <class T>
    static Image<T> columnsOf(const Image<T>& image, int first, int count) {
        Image<T> out(count, image.height());
        for (int y = 0; y < image.height(); ++y)
            for (int x = 0; x < count; ++x) out.at(x, y) = image.at(first + x, y);
        return out;
    }
    static formats::LightMapStrip columnsOf(const formats::LightMapStrip& band, int first, int count) {
        formats::LightMapStrip out;
        out.sh = columnsOf(band.sh, first, count);
        out.covered = columnsOf(band.covered, first, count);
        out.normal = columnsOf(band.normal, first, count);
        return out;
    }
    /// The blocks of a strip of samples, without what surrounds them, from block `first` of `out` on.
    template <class T>
    static void copyBlocks(const Image<T>& strip, Image<T>& out, int first) {
        constexpr int kSide = LightMapSamples::kSide, kMargin = LightMapSamples::kMargin;
        for (int y = 0; y < kChartBlock; ++y)
            for (int x = 0; x < strip.width() / kSide * kChartBlock; ++x)
                out.at(first * kChartBlock + x, y) = strip.at(x / kChartBlock * kSide + kMargin + x % kChartBlock, kMargin + y);
    }

    /// The covered texels, as ratios to what BC6H (or its like) makes of coefficient 0.
    void collect() {
        const float range = rows::constant(plan_, "range", 0);
        EncodeReport report;
        const rows::Layer l0 =
            rows::encodeHdr(plan_.textures[0].format, source_, 0, range, static_cast<float>(plan_.key), options_, true, report);
        ShadingMetric metric;
        glm::vec3 lastNormal(0);
        for (int x = 0; x < source_.width; ++x)
            for (int y = 0; y < kChartBlock; ++y) {
                if (source_.coverage.at(x, y) < 1) continue;
                Texel texel{x, y};
                texel.weight = blockWeight(texel) * std::sqrt(source_.importance.at(x, y));
                for (std::size_t c = 0; c < 3; ++c) {
                    const float stored = l0.decoded.at(x, y)[static_cast<int>(c)], dc = range * stored;
                    texel.light[c] = stored * stored;
                    for (std::size_t i = 0; i < kCount; ++i)
                        texel.ratio[c][i] = dc > 0 ? std::clamp(source_.values[i].at(x, y)[static_cast<int>(c)] / dc, -4.0f, 4.0f) : 0;
                    if (!(dc > 0)) texel.ratio[c][0] = 1;
                }
                const glm::ivec2 owner = source_.owner.at(x, y);
                const glm::vec3& normal = samples_.texels().normal.at(owner.x, owner.y);
                if (metrics_.empty() || normal != lastNormal) metrics_.push_back(metric.at(normal));
                lastNormal = normal;
                texel.metric = metrics_.size() - 1;
                texels_.push_back(texel);
            }
    }

    /// Texels weigh by what a player sees, their ratio, and by what rel_rms counts, their squares: half of the sum each. The second changes
    /// little but where a few texels of a lamp are nearly all of a map's light, which the first alone would not look at.
    void weighSquaresToo() {
        double seen = 0, squares = 0;
        for (const Texel& texel : texels_) {
            seen += static_cast<double>(totalWeight(texel));
            squares += static_cast<double>(blockWeight(texel) * lightOf(texel));
        }
        if (!(squares > 0)) return;
        const auto unit = static_cast<float>(seen / squares);
        for (Texel& texel : texels_) texel.weight += unit * blockWeight(texel);
    }
    /// How many blocks of the map a texel's own one stands for.
    float blockWeight(const Texel& texel) const { return samples_.choices()[static_cast<std::size_t>(texel.x / kChartBlock)].weight; }
    static float lightOf(const Texel& texel) { return texel.light[0] + texel.light[1] + texel.light[2]; }

    float totalWeight(const Texel& texel) const { return texel.weight * lightOf(texel); }
    BasisTarget targetOf(const Texel& texel) const { return {texel.ratio, texel.light, &metrics_[texel.metric]}; }

    /// A space in which squared distances are about what errors of the ratios cost: the mean metric's root, channel by channel.
    struct Space {
        Eigen::Matrix<float, 9, 9> root;  ///< upper: cost = |root e|^2
        std::array<float, 3> channel;
        int first;  ///< 0: all nine coefficients; 1: all but coefficient 0
    };
    template <class IsMember>
    Space spaceOf(int first, IsMember isMember) const {
        Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Identity() * 1e-30;
        std::array<double, 3> light = {1e-30, 1e-30, 1e-30};
        for (const Texel& texel : texels_) {
            if (!isMember(texel)) continue;
            const Metric& metric = metrics_[texel.metric];
            const double weight = static_cast<double>(totalWeight(texel));
            for (int i = 0; i < 9; ++i)
                for (int j = 0; j < 9; ++j)
                    sum(i, j) += weight * static_cast<double>(metric[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
            for (std::size_t c = 0; c < 3; ++c) light[c] += static_cast<double>(texel.weight * texel.light[c]);
        }
        sum /= sum.trace();
        sum += Eigen::Matrix<double, 9, 9>::Identity() * 1e-5;
        const double all = light[0] + light[1] + light[2];
        Space space{Eigen::Matrix<float, 9, 9>::Zero(), {}, first};
        const Eigen::Index size = 9 - first;
        const Eigen::MatrixXd part = sum.bottomRightCorner(size, size);
        space.root.bottomRightCorner(size, size) = Eigen::MatrixXd(part.llt().matrixU()).cast<float>();
        for (std::size_t c = 0; c < 3; ++c) space.channel[c] = static_cast<float>(std::sqrt(light[c] / all + 1e-6));
        return space;
    }
    static Eigen::VectorXf toSpace(const Space& space, const ByChannel& ratio) {
        const Eigen::Index size = 9 - space.first;
        Eigen::VectorXf out(3 * size);
        for (std::size_t c = 0; c < 3; ++c) {
            const Eigen::Map<const Eigen::Matrix<float, 9, 1>> r(ratio[c].data());
            const Eigen::VectorXf turned = space.root.bottomRightCorner(size, size) * r.tail(size);
            out.segment(static_cast<Eigen::Index>(c) * size, size) = space.channel[c] * turned;
        }
        return out;
    }
    static ByChannel fromSpace(const Space& space, const Eigen::VectorXf& point) {
        const Eigen::Index size = 9 - space.first;
        ByChannel out{};
        for (std::size_t c = 0; c < 3; ++c) {
            const Eigen::VectorXf r = space.root.bottomRightCorner(size, size)
                                          .triangularView<Eigen::Upper>()
                                          .solve(point.segment(static_cast<Eigen::Index>(c) * size, size)) /
                                      space.channel[c];
            for (Eigen::Index i = 0; i < size; ++i) out[c][static_cast<std::size_t>(space.first + i)] = r(i);
        }
        return out;
    }

    void cluster(const std::vector<int>& charts, int clusterCount) {
        const auto chartOfBlock = [&](int block) { return charts[static_cast<std::size_t>(block)]; };
        const auto chartOf = [&](const Texel& texel) {
            return chartOfBlock(samples_.choices()[static_cast<std::size_t>(texel.x / kChartBlock)].block);
        };
        // A few texels of each block say where it lies.
        const Space space = spaceOf(1, [](const Texel&) { return true; });
        std::vector<const Texel*> seeds;
        for (const Texel& texel : texels_)
            if ((texel.x + texel.y) % 3 == 0 || &texel == texels_.data() || chartOf(texel) != chartOf((&texel)[-1]))
                seeds.push_back(&texel);
        ChartPoints points;
        points.points.resize(24, static_cast<Eigen::Index>(seeds.size()));
        points.weights.resize(static_cast<Eigen::Index>(seeds.size()));
        for (std::size_t i = 0; i < seeds.size(); ++i) {
            const auto column = static_cast<Eigen::Index>(i);
            points.points.col(column) = toSpace(space, seeds[i]->ratio);
            points.weights(column) = totalWeight(*seeds[i]);
            points.chartOf.push_back(chartOf(*seeds[i]));
        }
        for (const int chart : charts) points.chartCount = std::max(points.chartCount, chart + 1);
        const std::vector<int> clusters = clusterCharts(points, model_.shape.codeChannels, clusterCount);
        int count = 1;
        for (const int cluster : clusters) count = std::max(count, cluster + 1);
        model_.code.assign(static_cast<std::size_t>(count), CodeTable{});
        model_.clusterOfBlock.resize(charts.size());
        int last = 0;  // blocks without light keep the index that lies before them: fewer runs
        for (std::size_t block = 0; block < charts.size(); ++block) {
            if (charts[block] >= 0) last = clusters[static_cast<std::size_t>(charts[block])];
            model_.clusterOfBlock[block] = static_cast<std::uint8_t>(last);
        }
        for (Texel& texel : texels_) texel.cluster = clusters[static_cast<std::size_t>(chartOf(texel))];
        byCluster_.resize(static_cast<std::size_t>(count));
        for (Texel& texel : texels_) byCluster_[static_cast<std::size_t>(texel.cluster)].push_back(&texel);
    }

    /// Points of one cluster in its own space.
    struct Points {
        Space space;
        Eigen::MatrixXf points;
        Eigen::VectorXf weights;
    };
    Points pointsOf(const std::vector<Texel*>& members, int cluster, int first) const {
        Points out{spaceOf(first, [&](const Texel& texel) { return texel.cluster == cluster; }), {}, {}};
        out.points.resize(3 * (9 - first), static_cast<Eigen::Index>(members.size()));
        out.weights.resize(static_cast<Eigen::Index>(members.size()));
        for (std::size_t i = 0; i < members.size(); ++i) {
            out.points.col(static_cast<Eigen::Index>(i)) = toSpace(out.space, members[i]->ratio);
            out.weights(static_cast<Eigen::Index>(i)) = totalWeight(*members[i]);
        }
        return out;
    }

    /// Principal coordinates, each a standard deviation wide.
    void startCodes() {
        for (std::size_t cluster = 0; cluster < byCluster_.size(); ++cluster) {
            const Points points = pointsOf(byCluster_[cluster], static_cast<int>(cluster), 1);
            if (points.weights.size() == 0) continue;
            const Subspace subspace = fitSubspace(points.points, points.weights, model_.shape.codeChannels, true);
            const Eigen::MatrixXf coordinates = subspace.directions.transpose() * (points.points.colwise() - subspace.mean);
            for (std::size_t i = 0; i < byCluster_[cluster].size(); ++i)
                for (int k = 0; k < model_.shape.codeChannels; ++k) {
                    const float unit = kDeviationsAcross * std::max(subspace.deviations(k), 1e-12f);
                    byCluster_[cluster][i]->code[k] = std::clamp(0.5f + coordinates(k, static_cast<Eigen::Index>(i)) / unit, 0.0f, 1.0f);
                }
        }
    }

    /// Monomials and their products, one of zeros added: whole registers.
    static constexpr Eigen::Index kPadded = 16;
    using Monomials = Eigen::Matrix<double, kPadded, 1>;
    using Products = Eigen::Matrix<double, kPadded, kPadded>;

    /// Least squares for every cluster's polynomial, codes given. A little of each factor's square keeps thin clusters calm.
    void fitDecode() {
        for (std::size_t cluster = 0; cluster < byCluster_.size(); ++cluster) fitTable(byCluster_[cluster], model_.code[cluster]);
    }
    void fitTable(const std::vector<Texel*>& members, CodeTable& table) const {
        std::array<Products, 3> normal;
        std::array<Eigen::Matrix<double, kPadded, 8>, 3> right;
        for (std::size_t c = 0; c < 3; ++c) {
            normal[c].setZero();
            right[c].setZero();
        }
        for (const Texel* texel : members) {
            const Monomials m = monomialsOf(texel->code);
            Products products = m * m.transpose();
            addNoise(texel->code, products);
            for (std::size_t c = 0; c < 3; ++c) {
                const double weight = static_cast<double>(texel->weight * texel->light[c]);
                normal[c] += weight * products;
                for (Eigen::Index i = 0; i < 8; ++i)
                    right[c].col(i) += (weight * static_cast<double>(texel->ratio[c][static_cast<std::size_t>(i) + 1])) * m;
            }
        }
        const Eigen::Index count = model_.shape.monomialCount();
        for (std::size_t c = 0; c < 3; ++c) {
            Eigen::MatrixXd matrix = normal[c].topLeftCorner(count, count);
            matrix.diagonal().array() += 1e-7 * matrix.trace() / static_cast<double>(count) + 1e-300;
            const Eigen::MatrixXd solved = matrix.ldlt().solve(right[c].topRows(count));
            for (Eigen::Index m = 0; m < count; ++m)
                for (Eigen::Index i = 0; i < 8; ++i)
                    table[static_cast<std::size_t>(m)][c][static_cast<std::size_t>(i)] =
                        std::isfinite(solved(m, i)) ? toHalf(solved(m, i)) : 0;
        }
    }
    /// What the block encoder's noise adds on average: its variance times the outer products of the monomials' derivatives. A decode that
    /// is fitted with it does not rest on differences of codes that will not survive.
    void addNoise(const glm::vec4& code, Products& products) const {
        const glm::dvec4 u(code);
        // Pairs of (monomial, derivative) by each code.
        using Term = std::pair<int, double>;
        const std::array<std::array<Term, 5>, 4> derivatives = {{{{{1, 1}, {4, 2 * u.x}, {5, u.y}, {6, u.z}, {11, u.w}}},
                                                                 {{{2, 1}, {5, u.x}, {7, 2 * u.y}, {8, u.z}, {12, u.w}}},
                                                                 {{{3, 1}, {6, u.x}, {8, u.y}, {9, 2 * u.z}, {13, u.w}}},
                                                                 {{{10, 1}, {11, u.x}, {12, u.y}, {13, u.z}, {14, 2 * u.w}}}}};
        const std::size_t terms = model_.shape.codeChannels == 3 ? 4 : 5;
        for (std::size_t k = 0; k < static_cast<std::size_t>(model_.shape.codeChannels); ++k)
            for (std::size_t a = 0; a < terms; ++a)
                for (std::size_t b = 0; b < terms; ++b)
                    products(derivatives[k][a].first, derivatives[k][b].first) +=
                        kCodeNoise * kCodeNoise * derivatives[k][a].second * derivatives[k][b].second;
    }
    static Monomials monomialsOf(const glm::vec4& code) {
        const glm::dvec4 u(code);
        Monomials m;
        m << 1, u.x, u.y, u.z, u.x * u.x, u.x * u.y, u.x * u.z, u.y * u.y, u.y * u.z, u.z * u.z, u.w, u.x * u.w, u.y * u.w, u.z * u.w,
            u.w * u.w, 0;
        return m;
    }

    /// visit(texel, its target, its cluster's decode as its metric sees it) for all, cluster by cluster.
    template <class Visit>
    void inTheirSpaces(Visit visit) {
        for (std::size_t cluster = 0; cluster < byCluster_.size(); ++cluster) {
            std::optional<CodeSpace> space;
            std::size_t metric = 0;
            for (Texel* texel : byCluster_[cluster]) {
                if (!space || metric != texel->metric) space.emplace(model_.code[cluster], model_.shape, metrics_[texel->metric]);
                metric = texel->metric;
                visit(*texel, targetOf(*texel), *space);
            }
        }
    }

    void solveCodes() {
        inTheirSpaces(
            [](Texel& texel, const BasisTarget& target, const CodeSpace& space) { texel.code = space.solve(target, texel.code).code; });
    }

    /// Makes each cluster's codes fill the box.
    void stretchCodes() {
        for (const std::vector<Texel*>& members : byCluster_)
            for (int k = 0; k < model_.shape.codeChannels; ++k) {
                double sum = 0, first = 0, second = 0;
                float low = 1, high = 0;
                for (const Texel* texel : members) {
                    const double weight = static_cast<double>(totalWeight(*texel)), value = static_cast<double>(texel->code[k]);
                    sum += weight;
                    first += weight * value;
                    second += weight * value * value;
                    low = std::min(low, texel->code[k]);
                    high = std::max(high, texel->code[k]);
                }
                if (!(sum > 0)) continue;
                const double mean = first / sum, deviation = std::sqrt(std::max(second / sum - mean * mean, 0.0));
                low = std::max(low, static_cast<float>(mean - static_cast<double>(kRangeDeviations) * deviation));
                high = std::min(high, static_cast<float>(mean + static_cast<double>(kRangeDeviations) * deviation));
                const float span = std::max(high - low, 1e-6f);
                for (Texel* texel : members) texel->code[k] = std::clamp((texel->code[k] - low) / span, 0.0f, 1.0f);
            }
    }

    /// Through the block encoder and back, some times: the decode is fitted to what comes out, so that codes settle where blocks can hold
    /// them. What the last time leaves is the residual's.
    void encodeCodes() {
        for (int round = 0;; ++round) {
            glm::dvec4 sensitivity(0);
            inTheirSpaces([&](const Texel& texel, const BasisTarget& target, const CodeSpace& space) {
                sensitivity += static_cast<double>(texel.weight) * glm::dvec4(space.sensitivity(target, texel.code));
            });
            model_.codeWeights = normalised(sensitivity);
            const Image<glm::vec4> decoded = throughEncoder(plan_.textures[1].format, model_.codeWeights);
            for (Texel& texel : texels_) texel.code = decoded.at(texel.x, texel.y);
            if (round == kEncodeRounds) break;
            fitDecode();
            solveCodes();
        }
        chooseSeeds();
        for (Texel& texel : texels_) {
            const HigherByChannel coded = evaluateCode(tableOf(texel), model_.shape.monomialCount(), texel.code);
            for (std::size_t c = 0; c < 3; ++c) {
                texel.ratio[c][0] -= 1;
                for (std::size_t i = 0; i < 8; ++i) texel.ratio[c][i + 1] -= coded[c][i];
            }
        }
    }
    const CodeTable& tableOf(const Texel& texel) const { return model_.code[static_cast<std::size_t>(texel.cluster)]; }

    /// Codes of each cluster to start a search from: some that lie far apart, each next one the farthest from all before it, and as many
    /// spread evenly over the sample, which lie where most texels do.
    void chooseSeeds() {
        model_.seeds.resize(byCluster_.size());
        for (std::size_t cluster = 0; cluster < byCluster_.size(); ++cluster) {
            const std::vector<Texel*>& members = byCluster_[cluster];
            std::vector<glm::vec4>& seeds = model_.seeds[cluster];
            std::vector<float> distance(members.size(), 1e30f);
            while (seeds.size() < kSeeds && seeds.size() < members.size()) {
                const auto farthest = static_cast<std::size_t>(std::ranges::max_element(distance) - distance.begin());
                if (!(distance[farthest] > 0)) break;
                seeds.push_back(members[farthest]->code);
                for (std::size_t i = 0; i < members.size(); ++i) {
                    const glm::vec4 apart = members[i]->code - seeds.back();
                    distance[i] = std::min(distance[i], glm::dot(apart, apart));
                }
            }
            for (std::size_t i = 0; i < kSeeds && members.size() > kSeeds; ++i) seeds.push_back(members[i * members.size() / kSeeds]->code);
        }
    }

    static glm::vec4 normalised(const glm::dvec4& sensitivity) {
        const double largest = std::max({sensitivity.x, sensitivity.y, sensitivity.z, sensitivity.w});
        return largest > 0 ? glm::vec4(glm::max(sensitivity / largest, glm::dvec4(1e-3))) : glm::vec4(1);
    }

    /// texel.code of the sample, encoded and decoded.
    Image<glm::vec4> throughEncoder(formats::PixelFormat format, const glm::vec4& channelWeights) const {
        Image<glm::vec4> image(source_.width, source_.height, glm::vec4(0.5f));
        Image<float> significance(source_.width, source_.height, 0);
        for (const Texel& texel : texels_) {
            image.at(texel.x, texel.y) = texel.code;
            significance.at(texel.x, texel.y) =
                source_.importance.at(texel.x, texel.y) * std::max(texel.light[0] + texel.light[1] + texel.light[2], 1e-20f);
        }
        EncodeOptions options = options_;
        for (int k = 0; k < 4; ++k) options.channelWeights[static_cast<std::size_t>(k)] = channelWeights[k];
        EncodeReport report;
        return std::move(rows::encodeLayer(format, image, significance, options, true, report).decoded);
    }

    /// Four linear directions of what is left, per cluster; then through the encoder, and fitted to what came out.
    void addResidualLayer() {
        std::vector<ResidualTable> tables(byCluster_.size(), ResidualTable{});
        for (std::size_t cluster = 0; cluster < byCluster_.size(); ++cluster) tables[cluster] = residualDirections(cluster);
        for (Texel& texel : texels_) texel.code = solveResidual(tables[static_cast<std::size_t>(texel.cluster)], targetOf(texel));
        glm::dvec4 sensitivity(0);
        for (const Texel& texel : texels_)
            sensitivity += static_cast<double>(texel.weight) *
                           glm::dvec4(residualSensitivity(tables[static_cast<std::size_t>(texel.cluster)], targetOf(texel)));
        model_.residualWeights.push_back(normalised(sensitivity));
        const Image<glm::vec4> decoded = throughEncoder(plan_.textures[2].format, model_.residualWeights.back());
        for (Texel& texel : texels_) texel.code = decoded.at(texel.x, texel.y);
        for (std::size_t cluster = 0; cluster < byCluster_.size(); ++cluster) refitResidual(byCluster_[cluster], tables[cluster]);
        for (Texel& texel : texels_) {
            ByChannel taken{};
            addResidual(tables[static_cast<std::size_t>(texel.cluster)], texel.code, taken);
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t i = 0; i < kCount; ++i) texel.ratio[c][i] -= taken[c][i];
        }
        model_.residual.push_back(std::move(tables));
    }

    ResidualTable residualDirections(std::size_t cluster) const {
        const Points points = pointsOf(byCluster_[cluster], static_cast<int>(cluster), 0);
        ResidualTable table{};
        if (points.weights.size() == 0) return table;
        const Subspace subspace = fitSubspace(points.points, points.weights, 4, false);
        const Eigen::MatrixXf coordinates = subspace.directions.transpose() * points.points;
        for (int k = 0; k < 4; ++k) {
            const float reach = std::min(coordinates.row(k).cwiseAbs().maxCoeff(), kRangeDeviations * subspace.deviations(k));
            // The shorter side of the box, 127/255, has to reach as far.
            const ByChannel direction = fromSpace(points.space, subspace.directions.col(k) * (reach / (1 - kResidualNeutral)));
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t i = 0; i < kCount; ++i)
                    table[static_cast<std::size_t>(k)][c][i] = toHalf(static_cast<double>(direction[c][i]));
        }
        return table;
    }

    static void refitResidual(const std::vector<Texel*>& members, ResidualTable& table) {
        for (std::size_t c = 0; c < 3; ++c) {
            Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
            Eigen::Matrix<double, 4, 9> right = Eigen::Matrix<double, 4, 9>::Zero();
            for (const Texel* texel : members) {
                Eigen::Vector4d b;
                for (int k = 0; k < 4; ++k) b(k) = static_cast<double>(texel->code[k] - kResidualNeutral);
                const double weight = static_cast<double>(texel->weight * texel->light[c]);
                normal += weight * b * b.transpose();
                for (int i = 0; i < 9; ++i)
                    right.col(i) += (weight * static_cast<double>(texel->ratio[c][static_cast<std::size_t>(i)])) * b;
            }
            // Towards the directions themselves where the codes say little.
            const double ridge = 1e-4 * normal.trace() / 4 + 1e-300;
            for (int k = 0; k < 4; ++k) {
                normal(k, k) += ridge;
                for (int i = 0; i < 9; ++i)
                    right(k, i) += ridge * static_cast<double>(table[static_cast<std::size_t>(k)][c][static_cast<std::size_t>(i)]);
            }
            const Eigen::Matrix<double, 4, 9> solved = normal.ldlt().solve(right);
            if (!solved.allFinite()) continue;
            for (int k = 0; k < 4; ++k)
                for (int i = 0; i < 9; ++i) table[static_cast<std::size_t>(k)][c][static_cast<std::size_t>(i)] = toHalf(solved(k, i));
        }
    }

    const LightMapPlan& plan_;
    const LightMapSamples& samples_;
    const EncodeOptions& options_;
    rows::Source source_;
    BasisModel model_;
    std::vector<Texel> texels_;
    std::vector<Metric> metrics_;
    std::vector<std::vector<Texel*>> byCluster_;
};

}  // namespace

BasisModel fitBasis(const LightMapPlan& plan, const BasisShape& shape, const LightMapSamples& samples, const std::vector<int>& charts,
                    int blocksAcross, int clusterCount, const EncodeOptions& options) {
    assert(clusterCount >= 1 && clusterCount <= 256);
    return BasisFitter(plan, shape, samples, options).run(charts, blocksAcross, clusterCount);
}

}  // namespace lightcook::compress
