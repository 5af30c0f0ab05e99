// This file is compiled once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "edge_mcl/core/image/table_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target must come first.
#include <hwy/highway.h>

#include <algorithm>

#include "edge_mcl/core/image/table_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace edge_mcl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void relaxRowImpl(const uint8_t* source, uint8_t none, uint8_t* target, size_t count) {
  const hn::ScalableTag<uint8_t> d;
  const size_t lanes = hn::Lanes(d);
  const auto one = hn::Set(d, 1), most = hn::Set(d, none);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto next = hn::Min(hn::Add(hn::LoadU(d, source + i), one), most);
    hn::StoreU(hn::Min(hn::LoadU(d, target + i), next), d, target + i);
  }
  for (; i < count; ++i) {
    const auto next = std::min(static_cast<uint8_t>(source[i] + 1), none);
    target[i] = std::min(target[i], next);
  }
}

#if HWY_TARGET != HWY_SCALAR
/// Lookup in tables of at most 32 entries.
void lookUpShort(const uint8_t* in, const uint8_t* const* table_of_cell, size_t cells,
                 uint8_t* out) {
  const hn::FixedTag<uint8_t, 16> d_table;
  const hn::FixedTag<uint8_t, 8> d;
  const auto low_bits = hn::Set(d, 15);
  for (size_t c = 0; c < cells; ++c) {
    const auto index = hn::LoadU(d, in + 8 * c);
    const auto part = hn::And(index, low_bits);
    const auto first = hn::TableLookupBytes(hn::LoadU(d_table, table_of_cell[c]), part);
    const auto second = hn::TableLookupBytes(hn::LoadU(d_table, table_of_cell[c] + 16), part);
    hn::StoreU(hn::IfThenElse(hn::Eq(index, part), first, second), d, out + 8 * c);
  }
}
#endif

void lookUpByCellImpl(const uint8_t* in, const uint8_t* const* table_of_cell,
                      [[maybe_unused]] size_t entries, size_t cells, uint8_t* out) {
#if HWY_TARGET != HWY_SCALAR
  if (entries <= 32) return lookUpShort(in, table_of_cell, cells, out);
#endif
  for (size_t i = 0; i < 8 * cells; ++i) out[i] = table_of_cell[i / 8][in[i]];
}

void interleaveRowImpl(const uint8_t* low, const uint8_t* high, size_t count, uint16_t* out) {
  const hn::ScalableTag<uint16_t> d;
  const hn::Rebind<uint8_t, decltype(d)> narrow;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto a = hn::PromoteTo(d, hn::LoadU(narrow, low + i));
    const auto b = hn::PromoteTo(d, hn::LoadU(narrow, high + i));
    hn::StoreU(hn::Or(a, hn::ShiftLeft<8>(b)), d, out + i);
  }
  for (; i < count; ++i) out[i] = static_cast<uint16_t>(low[i] | high[i] << 8);
}

}  // namespace HWY_NAMESPACE
}  // namespace edge_mcl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace edge_mcl {
HWY_EXPORT(relaxRowImpl);
HWY_EXPORT(lookUpByCellImpl);
HWY_EXPORT(interleaveRowImpl);

void relaxRow(const uint8_t* source, uint8_t none, uint8_t* target, size_t count) {
  HWY_DYNAMIC_DISPATCH(relaxRowImpl)(source, none, target, count);
}

void lookUpByCell(const uint8_t* in, const uint8_t* const* table_of_cell, size_t entries,
                  size_t cells, uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(lookUpByCellImpl)(in, table_of_cell, entries, cells, out);
}

void interleaveRow(const uint8_t* low, const uint8_t* high, size_t count, uint16_t* out) {
  HWY_DYNAMIC_DISPATCH(interleaveRowImpl)(low, high, count, out);
}

}  // namespace edge_mcl
#endif
