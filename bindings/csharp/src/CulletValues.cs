// Points, matrices, and what makes views, settings and instances.
using System;
using System.Runtime.InteropServices;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>Three floats: a point, or a size.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletFloat3
    {
        /// <summary>Each number.</summary>
        public float X, Y, Z;

        /// <summary>Makes a point.</summary>
        public CulletFloat3(float x, float y, float z)
        {
            X = x;
            Y = y;
            Z = z;
        }
    }

    /// <summary>Three doubles: a point of the world.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletDouble3
    {
        /// <summary>Each number.</summary>
        public double X, Y, Z;

        /// <summary>Makes a point.</summary>
        public CulletDouble3(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }
    }

    /// <summary>The linear part of a transform: its columns, which are the images of the three axes.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletLinear
    {
        /// <summary>Each column.</summary>
        public CulletFloat3 X, Y, Z;

        /// <summary>Makes a linear part of its columns.</summary>
        public CulletLinear(CulletFloat3 x, CulletFloat3 y, CulletFloat3 z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <summary>Returns a scale along the axes.</summary>
        public static CulletLinear Scale(float x, float y, float z) => new CulletLinear(
            new CulletFloat3(x, 0, 0), new CulletFloat3(0, y, 0), new CulletFloat3(0, 0, z));
    }

    /// <summary>A matrix of 4 times 4 doubles, column-major. Fill it by its indexer.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct CulletMatrix
    {
        fixed double values[16];

        /// <summary>The number in row i mod 4 of column i / 4.</summary>
        public double this[int i]
        {
            get
            {
                if ((uint)i >= 16) throw new IndexOutOfRangeException();
                fixed (double* all = values) return all[i];
            }
            set
            {
                if ((uint)i >= 16) throw new IndexOutOfRangeException();
                fixed (double* all = values) all[i] = value;
            }
        }
    }

    /// <summary>Two handles of instances.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletHandlePair
    {
        /// <summary>Each handle.</summary>
        public CulletHandle First, Second;
    }

    public partial struct CulletBox
    {
        /// <summary>Makes a box of its lowest and its highest corner.</summary>
        public CulletBox(CulletFloat3 min, CulletFloat3 max)
        {
            Min = min;
            Max = max;
        }

        /// <summary>Makes a box of the numbers of its lowest and its highest corner.</summary>
        public CulletBox(float minX, float minY, float minZ, float maxX, float maxY, float maxZ)
            : this(new CulletFloat3(minX, minY, minZ), new CulletFloat3(maxX, maxY, maxZ))
        {
        }
    }

    public partial struct CulletTransform
    {
        /// <summary>Makes a transform.</summary>
        public CulletTransform(CulletLinear linear, CulletDouble3 translation)
        {
            Linear = linear;
            Translation = translation;
        }

        /// <summary>Returns a move.</summary>
        public static CulletTransform At(double x, double y, double z) =>
            new CulletTransform(CulletLinear.Scale(1, 1, 1), new CulletDouble3(x, y, z));
    }

    public partial struct CulletInstance
    {
        /// <summary>Makes an instance in layer 0.</summary>
        public CulletInstance(uint mesh, CulletTransform transform, ulong user = 0)
        {
            Transform = transform;
            Mesh = mesh;
            Layers = 1;
            Flags = CulletInstanceFlags.None;
            reserved = 0;
            User = user;
        }
    }

    public partial struct CulletLight
    {
        /// <summary>Returns a light of parallel rays, which travel along a direction.</summary>
        public static CulletLight Directional(CulletDouble3 direction) =>
            new CulletLight { Kind = CulletLightKind.Directional, Direction = direction };

        /// <summary>Returns a light that shines all around.</summary>
        public static CulletLight Point(CulletDouble3 position, double range) =>
            new CulletLight { Kind = CulletLightKind.Point, Position = position, Range = range };

        /// <summary>Returns a light that shines into a cone; the angle is between its axis and its side, in
        /// radians.</summary>
        public static CulletLight Spot(
            CulletDouble3 position, CulletDouble3 direction, double range, double halfAngle) =>
            new CulletLight
            {
                Kind = CulletLightKind.Spot,
                Position = position,
                Direction = direction,
                Range = range,
                HalfAngle = halfAngle
            };
    }

    public unsafe partial struct CulletSettings
    {
        /// <summary>Returns the settings of a preset.</summary>
        public static CulletSettings Preset(CulletPreset preset)
        {
            CulletSettings settings;
            CulletLibrary.Check(cullet_settings_preset((uint)preset, &settings));
            return settings;
        }
    }

    public unsafe partial struct CulletView
    {
        /// <summary>Returns a perspective view from a point to another, +Y up, with reversed depth and no far plane.
        /// The field of view is the full vertical one, in radians.</summary>
        public static CulletView LookAt(
            CulletDouble3 eye, CulletDouble3 target, double fovY, double nearPlane, int width, int height)
        {
            CulletView view;
            CulletLibrary.Check(cullet_view_look_at(
                (double*)&eye, (double*)&target, fovY, nearPlane, (uint)width, (uint)height, &view));
            return view;
        }

        /// <summary>Returns a view from a matrix that takes world to clip space, with depth 0 to 1.</summary>
        public static CulletView FromMatrix(in CulletMatrix clipFromWorld, CulletDepth depth, int width, int height)
        {
            CulletView view;
            CulletMatrix matrix = clipFromWorld;
            CulletLibrary.Check(
                cullet_view_from_matrix((double*)&matrix, (uint)depth, (uint)width, (uint)height, &view));
            return view;
        }

        /// <summary>Returns a view from 16 numbers, column-major, that take world to clip space, with depth 0 to
        /// 1.</summary>
        public static CulletView FromMatrix(
            ReadOnlySpan<double> clipFromWorld, CulletDepth depth, int width, int height)
        {
            CulletLibrary.SameLength(16, clipFromWorld.Length, nameof(clipFromWorld));
            var matrix = new CulletMatrix();
            for (int i = 0; i < 16; i++) matrix[i] = clipFromWorld[i];
            return FromMatrix(matrix, depth, width, height);
        }

        /// <summary>Returns the view of a camera.</summary>
        public static CulletView FromCamera(in CulletCamera camera, CulletDepth depth, int width, int height)
        {
            CulletView view;
            CulletCamera copy = camera;
            CulletLibrary.Check(cullet_view_from_camera(&copy, (uint)depth, (uint)width, (uint)height, &view));
            return view;
        }
    }
}
