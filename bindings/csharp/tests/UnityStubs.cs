// As much of Unity as Unity/CulletRenderers.cs names, so that it compiles and one frame of it runs. It is not Unity.
using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public struct Vector3
    {
        public float x, y, z;

        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }

        public static Vector3 operator *(Vector3 a, float by) => new Vector3(a.x * by, a.y * by, a.z * by);
    }

    public struct Bounds
    {
        public Vector3 min { get; set; }

        public Vector3 max { get; set; }
    }

    public struct Matrix4x4
    {
        internal float[] All;

        public float this[int index] => All[index];

        public static Matrix4x4 operator *(Matrix4x4 a, Matrix4x4 b)
        {
            var all = new float[16];
            for (int i = 0; i < 16; i++)
                for (int k = 0; k < 4; k++) all[i] += a[4 * k + i % 4] * b[i / 4 * 4 + k];
            return new Matrix4x4 { All = all };
        }
    }

    public class Object
    {
        internal static readonly List<Object> All = new List<Object>();

        public static T[] FindObjectsOfType<T>() where T : Object => All.OfType<T>().ToArray();
    }

    public class Component : Object
    {
        public Transform transform { get; } = null;

        public T GetComponent<T>() where T : Component => All.OfType<T>().First();

        internal Component(Transform at = null)
        {
            transform = at;
        }
    }

    public sealed class Transform
    {
        public Matrix4x4 localToWorldMatrix { get; set; }
    }

    public class MonoBehaviour : Component
    {
    }

    public sealed class Camera : Component
    {
        public Matrix4x4 projectionMatrix { get; set; }

        public Matrix4x4 worldToCameraMatrix { get; set; }

        public int pixelWidth => 640;

        public int pixelHeight => 400;
    }

    public sealed class Renderer : Component
    {
        public Bounds bounds { get; set; }

        public bool forceRenderingOff { get; set; }
    }

    public sealed class BoxCollider : Component
    {
        public Vector3 center { get; set; }

        public Vector3 size { get; set; }

        internal BoxCollider(Transform at) : base(at)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class RequireComponent : Attribute
    {
        public RequireComponent(Type type)
        {
        }
    }
}

namespace Cullet.Tests
{
    using System.Reflection;
    using UnityEngine;

    static class UnityFrame
    {
        static Matrix4x4 Matrix(params float[] columns) => new Matrix4x4 { All = columns };

        static void Send(CulletRenderers to, string message) =>
            typeof(CulletRenderers).GetMethod(message, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(to, null);

        static Renderer Box(float x, float z) => new Renderer
            { bounds = new Bounds { min = new Vector3(x - 1, -1, z - 1), max = new Vector3(x + 1, 1, z + 1) } };

        static int Visible(float[] positions, uint[] indices)
        {
            var numbers = new double[] { 1.25, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1.001, 1, 0, 0, -0.1001, 0 };
            CulletView view = CulletView.FromMatrix(numbers, CulletDepth.Standard, 640, 400);
            CulletSettings settings = CulletSettings.Preset(CulletPreset.Exact);
            settings.Output = CulletOutput.Triangles;
            using (var scene = new CulletScene())
            using (var state = new CulletState())
            {
                uint mesh = scene.AddMesh(positions, indices, CulletMeshFlags.OneSided);
                scene.Add(new CulletInstance(mesh, CulletTransform.At(0, 0, 0)));
                scene.Commit();
                state.Cull(scene, view, settings);
                return state.VisibleCount;
            }
        }

        /// <summary>The camera stands at 0 and looks along +z, as in Unity; its matrices are those of Unity's
        /// pages.</summary>
        internal static void Run()
        {
            const float n = 0.1f, f = 1000, t = 2;
            var camera = new Camera
            {
                projectionMatrix = Matrix(t * 400 / 640, 0, 0, 0, 0, t, 0, 0, 0, 0, -(f + n) / (f - n), -1, 0, 0,
                    -2 * f * n / (f - n), 0),
                worldToCameraMatrix = Matrix(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1)
            };
            // Before the wall, behind it, behind the eye, and beside the wall.
            Renderer[] four = { Box(0, 8), Box(0, 20), Box(0, -20), Box(9, 20) };
            Object.All.Add(camera);
            Object.All.AddRange(four);
            var at = new Transform { localToWorldMatrix =
                Matrix(10, 0, 0, 0, 0, 10, 0, 0, 0, 0, 1, 0, 0, 0, 10.5f, 1) };
            var culling = new CulletRenderers { occluders =
                new[] { new BoxCollider(at) { size = new Vector3(1, 1, 1) } } };
            Send(culling, "OnEnable");
            Send(culling, "LateUpdate");
            Check.Equal("0 1 1 0", string.Join(" ", four.Select(r => r.forceRenderingOff ? 1 : 0)),
                "renderers that are off");
            Send(culling, "OnDisable");
            Check.That(four.All(r => !r.forceRenderingOff), "all renderers are on again");
            // A square that is clockwise as the camera sees it is a front in Unity, and its other side is none.
            float[] square = { -1, -1, 10, -1, 1, 10, 1, 1, 10, 1, -1, 10 };
            Check.Equal(1, Visible(square, new uint[] { 0, 1, 2, 0, 2, 3 }), "visible fronts");
            Check.Equal(0, Visible(square, new uint[] { 0, 2, 1, 0, 3, 2 }), "visible backs");
        }
    }
}
