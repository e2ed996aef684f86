// What all objects share: errors, handles that are destroyed once, texts.
using System;
using System.Text;
using System.Threading;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>The error of a call that the library refused. <c>Message</c> names the argument, the value, the limit
    /// and what to do.</summary>
    public sealed class CulletException : Exception
    {
        /// <summary>The status that the call returned.</summary>
        public CulletStatus Status { get; }

        /// <summary>Makes an error of a status and a message.</summary>
        public CulletException(CulletStatus status, string message) : base(message)
        {
            Status = status;
        }
    }

    /// <summary>Functions of the library as a whole.</summary>
    public static unsafe class CulletLibrary
    {
        /// <summary>The version of the library, such as "0.2.0".</summary>
        public static string Version => Text(cullet_version());

        /// <summary>Returns the name of a stage, such as "frustum".</summary>
        public static string Name(CulletStage stage) => Text(cullet_stage_name((uint)stage));

        /// <summary>Returns the name of a status, such as "stale handle".</summary>
        public static string Name(CulletStatus status) => Text(cullet_status_name((int)status));

        /// <summary>Returns the name of a unit of a funnel: "instances", "clusters" or "triangles".</summary>
        public static string UnitName(uint unit) => Text(cullet_unit_name(unit));

        /// <summary>Throws a <see cref="CulletException"/> with the calling thread's last error, unless a status is OK.
        /// For calls of <see cref="CulletNative"/>: nothing may stand between the call and this.</summary>
        public static void Check(CulletStatus status)
        {
            if (status != CulletStatus.Ok) throw new CulletException(status, Text(cullet_last_error()));
        }

        internal static string Text(byte* text)
        {
            int length = 0;
            while (text[length] != 0) length++;
            return Encoding.UTF8.GetString(text, length);
        }

        /// <summary>Returns a text as UTF-8 with a 0 at its end.</summary>
        internal static byte[] Utf8(string text, string name)
        {
            if (text == null) throw new ArgumentNullException(name);
            // The library would read up to the first 0, and open another file.
            if (text.IndexOf('\0') >= 0) throw new ArgumentException("the text has a character 0 in it", name);
            return Encoding.UTF8.GetBytes(text + '\0');
        }

        internal static UIntPtr Size(int count) => (UIntPtr)(uint)count;

        /// <summary>Refuses arrays that must be equally long: the library has one count for both.</summary>
        internal static void SameLength(int first, int second, string name)
        {
            if (first != second) throw new ArgumentException($"{name} has {second} entries: {first} are needed", name);
        }

        /// <summary>Refuses an output that has no room for all entries.</summary>
        internal static void Room(int needed, int room, string name)
        {
            if (room < needed) throw new ArgumentException($"{name} has room for {room} entries: {needed} are needed",
                name);
        }

        /// <summary>Returns how many vertices floats make.</summary>
        internal static int Vertices(int floats, string name)
        {
            if (floats % 3 == 0) return floats / 3;
            throw new ArgumentException($"{name} has {floats} floats: they must be three for each vertex", name);
        }

        internal static ulong IdOf(CulletObject given, string name)
        {
            if (given == null) throw new ArgumentNullException(name);
            return given.Id;
        }
    }

    /// <summary>An object of the library. It is destroyed by <see cref="Dispose"/>, or by the garbage collector some
    /// time after the last use. Any thread may use it; a call that another excludes throws with
    /// <see cref="CulletStatus.Busy"/>.</summary>
    public abstract class CulletObject : IDisposable
    {
        long id;

        internal CulletObject()
        {
        }

        /// <summary>The number of the handle, for calls of <see cref="CulletNative"/>. Keep the object alive as long as
        /// you use it.</summary>
        public ulong Id
        {
            get
            {
                long now = Interlocked.Read(ref id);
                if (now == 0) throw new ObjectDisposedException(GetType().Name);
                return (ulong)now;
            }
        }

        /// <summary>Whether it was disposed of.</summary>
        public bool IsDisposed => Interlocked.Read(ref id) == 0;

        internal void Take(ulong made) => Interlocked.Exchange(ref id, (long)made);

        internal abstract CulletStatus Destroy(ulong id);

        /// <summary>Throws unless a status is OK. The collector does not take the objects of the call before it has
        /// returned.</summary>
        internal void Check(CulletStatus status, CulletObject second = null, CulletObject third = null)
        {
            if (status != CulletStatus.Ok) CulletLibrary.Check(status);
            GC.KeepAlive(this);
            GC.KeepAlive(second);
            GC.KeepAlive(third);
        }

        /// <summary>Destroys the object; a second call does nothing. Throws a <see cref="CulletException"/> only where
        /// another thread is using it, and then may be called again.</summary>
        public void Dispose()
        {
            long now = Interlocked.Exchange(ref id, 0);
            if (now == 0) return;
            CulletStatus status = Destroy((ulong)now);
            if (status == CulletStatus.Busy)
            {
                Interlocked.Exchange(ref id, now);
                CulletLibrary.Check(status);
            }
            GC.SuppressFinalize(this);
        }

        /// <summary>Destroys the object if nobody did.</summary>
        ~CulletObject()
        {
            if (id != 0) Destroy((ulong)id);
        }
    }
}
