"""What numba has no name for: a product and a sum rounded once, and the signs of determinants of integers."""

from numba import types
from numba.core.cgutils import ir
from numba.extending import intrinsic

_WORD = 64


@intrinsic
def fma(typing_context, a, b, c):
    """``a * b + c``, rounded once (IEEE 754-2008, 5.4.1): by the processor, or the C library where that cannot."""

    def codegen(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), codegen


class _Integer:
    """A number while code is generated: a product has room for any, a sum no more than the wider of its terms."""

    def __init__(self, builder: ir.IRBuilder, value: ir.Value):
        self.builder, self.value, self.bits = builder, value, value.type.width

    def _widened(self, bits: int) -> ir.Value:
        return self.builder.sext(self.value, ir.IntType(bits)) if bits > self.bits else self.value

    def _combined(self, other: "_Integer", operation, bits: int) -> "_Integer":
        return _Integer(self.builder, operation(self._widened(bits), other._widened(bits)))

    def __mul__(self, other: "_Integer") -> "_Integer":
        return self._combined(other, self.builder.mul, self.bits + other.bits)

    def __add__(self, other: "_Integer") -> "_Integer":
        return self._combined(other, self.builder.add, max(self.bits, other.bits))

    def __sub__(self, other: "_Integer") -> "_Integer":
        return self._combined(other, self.builder.sub, max(self.bits, other.bits))

    def sign(self) -> ir.Value:
        """-1, 0 or 1 in 64 bits."""
        zero, word = ir.Constant(ir.IntType(self.bits), 0), ir.IntType(_WORD)
        positive, negative = (self.builder.icmp_signed(relation, self.value, zero) for relation in "><")
        return self.builder.sub(self.builder.zext(positive, word), self.builder.zext(negative, word))


def _determinant(p: tuple, q: tuple, r: tuple) -> _Integer:
    """That of three rows."""
    return (
        p[2] * (q[0] * r[1] - q[1] * r[0])
        + q[2] * (r[0] * p[1] - r[1] * p[0])
        + r[2] * (p[0] * q[1] - p[1] * q[0])
    )  # fmt: skip


def _rows(builder: ir.IRBuilder, arguments: list[ir.Value]) -> list[tuple]:
    numbers = [_Integer(builder, value) for value in arguments]
    return [tuple(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]


@intrinsic
def sign_of_orient3d(typing_context, ax, ay, az, bx, by, bz, cx, cy, cz):
    """The sign of the determinant of three rows of integers up to 2^61: below 2^186, in 192 bits."""

    def codegen(context, builder, signature, arguments):
        return _determinant(*_rows(builder, arguments)).sign()

    return types.int64(*[types.int64] * 9), codegen


@intrinsic
def sign_of_incircle(typing_context, ax, ay, bx, by, cx, cy):
    """The same of rows of two with their squared lengths: below 2^248, in 256 bits."""

    def codegen(context, builder, signature, arguments):
        numbers = [_Integer(builder, value) for value in arguments]
        rows = [(x, y, x * x + y * y) for x, y in zip(numbers[::2], numbers[1::2], strict=True)]
        return _determinant(*rows).sign()

    return types.int64(*[types.int64] * 6), codegen


@intrinsic
def sign_of_insphere(typing_context, ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """The same of four rows of three with their squared lengths: below 2^312, in 320 bits."""

    def codegen(context, builder, signature, arguments):
        a, b, c, d = _rows(builder, arguments)
        aw, bw, cw, dw = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] for p in (a, b, c, d))
        positive = dw * _determinant(a, b, c) + bw * _determinant(a, c, d)
        return (positive - cw * _determinant(a, b, d) - aw * _determinant(b, c, d)).sign()

    return types.int64(*[types.int64] * 12), codegen
