// Of several ranks each has whole blocks of rows, one after another; together they have all.
#include "splat/train/ranks/row_share.h"

#include <gtest/gtest.h>

namespace cosplat {
namespace {

TEST(RowShare, DividesRowsWithoutGaps) {
  for (const uint32_t ranks : {1u, 2u, 3u, 7u})
    for (const size_t rows :
         {size_t(0), size_t(1), kRowsPerBlock, 3 * kRowsPerBlock + 5, 14 * kRowsPerBlock}) {
      size_t owned = 0;
      for (uint32_t rank = 0; rank < ranks; ++rank) {
        const RowShare share{rank, ranks};
        size_t next = 0;
        for (size_t row = 0; row < rows; ++row)
          if (share.Owns(row)) EXPECT_EQ(share.PlaceOf(row), next++);
        EXPECT_EQ(share.CountOf(rows), next) << rank << " of " << ranks << ", " << rows << " rows";
        owned += next;
      }
      EXPECT_EQ(owned, rows);
    }
}

TEST(RowShare, OfOneRankIsTheIdentity) {
  const RowShare all;
  for (const size_t row : {size_t(0), size_t(511), size_t(512), size_t(123456)}) {
    EXPECT_TRUE(all.Owns(row));
    EXPECT_EQ(all.PlaceOf(row), row);
  }
}

}  // namespace
}  // namespace cosplat
