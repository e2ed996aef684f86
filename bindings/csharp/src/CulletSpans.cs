#if CULLET_NO_SPAN
// Spans over arrays, for hosts without System.Span: define CULLET_NO_SPAN. Pointers of your own go through
// CulletNative.
using System;

namespace Cullet
{
    /// <summary>A part of an array that is only read.</summary>
    public readonly struct ReadOnlySpan<T>
    {
        internal readonly T[] Array;
        internal readonly int Start;

        /// <summary>How many elements there are.</summary>
        public int Length { get; }

        /// <summary>Makes a span of a part of an array.</summary>
        public ReadOnlySpan(T[] array, int start, int length)
        {
            int all = array == null ? 0 : array.Length;
            if (start < 0 || length < 0 || start > all - length) throw new ArgumentOutOfRangeException(nameof(length));
            Array = array;
            Start = start;
            Length = length;
        }

        /// <summary>Whether there are no elements.</summary>
        public bool IsEmpty => Length == 0;

        /// <summary>The element at an index.</summary>
        public T this[int index] => new Span<T>(Array, Start, Length)[index];

        /// <summary>Makes a span of all of an array; null is empty.</summary>
        public static implicit operator ReadOnlySpan<T>(T[] array) =>
            new ReadOnlySpan<T>(array, 0, array == null ? 0 : array.Length);
    }

    /// <summary>A part of an array.</summary>
    public readonly struct Span<T>
    {
        internal readonly T[] Array;
        internal readonly int Start;

        /// <summary>How many elements there are.</summary>
        public int Length { get; }

        /// <summary>Makes a span of a part of an array.</summary>
        public Span(T[] array, int start, int length)
        {
            var checkedPart = new ReadOnlySpan<T>(array, start, length);
            Array = array;
            Start = start;
            Length = checkedPart.Length;
        }

        /// <summary>Whether there are no elements.</summary>
        public bool IsEmpty => Length == 0;

        /// <summary>The element at an index.</summary>
        public ref T this[int index]
        {
            get
            {
                if ((uint)index >= (uint)Length) throw new IndexOutOfRangeException();
                return ref Array[Start + index];
            }
        }

        /// <summary>Makes a span of all of an array; null is empty.</summary>
        public static implicit operator Span<T>(T[] array) => new Span<T>(array, 0, array == null ? 0 : array.Length);

        /// <summary>Makes a span that is only read.</summary>
        public static implicit operator ReadOnlySpan<T>(Span<T> span) =>
            new ReadOnlySpan<T>(span.Array, span.Start, span.Length);
    }

    static class MemoryMarshal
    {
        static class Nothing<T>
        {
            internal static readonly T[] One = new T[1];
        }

        /// <summary>Returns the first element, or one that is not used where there is none.</summary>
        internal static ref T GetReference<T>(ReadOnlySpan<T> span)
        {
            if (span.Length == 0) return ref Nothing<T>.One[0];
            return ref span.Array[span.Start];
        }

        internal static ref T GetReference<T>(Span<T> span) => ref GetReference((ReadOnlySpan<T>)span);
    }
}
#endif
