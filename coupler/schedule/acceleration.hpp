#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sluice {

//! One column of the joint fixed-point vector: a data column of a lag-1 edge of the group.
struct AccelerationColumn
{
    std::string name;         //!< "load.force", for messages
    double tolerance = 1e-6;  //!< converged when |x~ - x| <= tolerance |x~|, 2-norms over all points of the column
    double floor = 1e-20;     //!< or when |x~ - x| <= floor, in the column's unit: below it a number is noise
};

//! How a group gets from what was used (x) and what came of it (x~ = H(x)) to the next input. The same in all members.
struct AccelerationConfig
{
    enum class Method
    {
        constant,  //!< x + relaxation (x~ - x)
        aitken,    //!< the same with a factor that is adapted in every iteration
        iqn_ils    //!< interface quasi-Newton, inverse from least squares
    };
    Method method = Method::iqn_ils;
    double relaxation = 0.5;  //!< of all iterations (constant), or of the first ones while nothing better is known
    int history = 8;          //!< windows whose differences IQN-ILS reuses, >= 0
    std::vector<AccelerationColumn> columns;
};

//! The joint state of one column after an iteration.
struct ColumnVerdict
{
    double residual = 0;  //!< |x~ - x|, in the column's unit
    double result = 0;    //!< |x~|
    bool converged = false;
};

struct Verdict
{
    bool converged = false;              //!< every column is
    std::vector<ColumnVerdict> columns;  //!< in the order of AccelerationConfig::columns
};

//! What a group decided: the same bits in every member.
struct AccelerationStep
{
    double relaxation = 0;             //!< factor of a relaxation step; 0: a quasi-Newton step
    std::vector<double> coefficients;  //!< c of x~ + W c, newest difference first, 0 where a difference was dropped
    std::vector<std::size_t> kept;     //!< the differences that passed the filter; the others are forgotten
};

//! Differences of one block, relaxation and window count as plain numbers, for a checkpoint.
struct AccelerationState
{
    std::vector<std::int64_t> numbers;
    std::vector<double> values;
};

//! Judges an iteration from the summaries of all blocks of the group, in the order of their numbers. Members that own
//! no block call it too. Throws Error: protocol if the summaries do not belong together, numerical if a norm
//! overflowed.
Verdict judge(AccelerationConfig const& config, std::span<std::vector<double> const> summaries);

//! One receiver's part of one lag-1 edge: it alone holds the vectors, the group sees summaries.
//!
//!     block.begin_window(ids)
//!     repeat: compute with x; x~ has come -> summary(x, x~), exchanged all to all in the order of block numbers;
//!             judge(config, summaries).converged ? block.accept(), next window : block.next(summaries, x)
//!
//! Values are given as in a Frame: one vector per column, points * components numbers, interleaved per point.
class AccelerationBlock
{
 public:
    using Columns = std::vector<std::vector<double>>;
    struct Column
    {
        int joint = 0;       //!< index into AccelerationConfig::columns, each at most once in a block
        int components = 1;  //!< numbers per point
    };

    //! `number`: of this block, unique in the group.
    AccelerationBlock(AccelerationConfig config, int number, std::vector<Column> columns);

    //! The points of the coming window; they stay until the next call. Differences of earlier windows follow their ids,
    //! those of new points are 0. Ids must be unique.
    void begin_window(std::span<std::int64_t const> ids);
    //! Takes an iteration's input and result; returns what the group must see. Throws Error (numerical): not finite.
    std::vector<double> summary(Columns const& used, Columns const& result);
    //! Writes the next input. `summaries`: of all blocks, in the order of their numbers. Errors: see judge.
    AccelerationStep next(std::span<std::vector<double> const> summaries, Columns& next_input);
    //! The window is done: its differences become history.
    void accept();

    //! Between accept() and begin_window().
    AccelerationState save() const;
    //! Throws Error (io) if the state is not that of a block with these columns.
    void restore(AccelerationState const& state);

 private:
    struct Difference
    {
        std::int64_t window;           //!< in which it was made
        std::vector<double> residual;  //!< r_k - r_{k-1}: a column of V
        std::vector<double> result;    //!< x~_k - x~_{k-1}: a column of W
    };

    std::size_t width() const;  //!< numbers per point
    std::vector<double> joined(Columns const& columns) const;
    void check_finite(Columns const& columns, char const* what) const;
    void remember_difference();
    std::vector<double> factor_of(std::size_t first, std::size_t size) const;
    void move_to(std::vector<double>& values, std::vector<std::int64_t> const& source) const;

    AccelerationConfig config_;
    int number_;
    std::vector<Column> columns_;
    std::vector<std::int64_t> ids_;
    std::int64_t window_ = 0;
    int iteration_ = 0;                                                           //!< summaries made in this window
    double relaxation_;                                                           //!< Aitken's last factor
    std::vector<Difference> differences_;                                         //!< newest first
    std::vector<double> used_, result_, residual_, last_result_, last_residual_;  //!< column after column
};

}  // namespace sluice
