// Switches the renderers of a Unity scene on and off by what the camera may see, each frame, behind boxes that you
// place. No Unity has run this: it is compiled against stubs (tests/UnityStubs.cs), as the chapter of the book says.
using System.Collections.Generic;
using Cullet;
using UnityEngine;

/// <summary>Put it on a camera, the only one. Box colliders in <see cref="occluders"/> hide; all renderers of the scene
/// are culled by their bounds. A renderer that is off casts no shadow and shows in no reflection: leave out those whose
/// shadows reach into the view.</summary>
[RequireComponent(typeof(Camera))]
public sealed class CulletRenderers : MonoBehaviour
{
    /// <summary>Opaque boxes, each within what is drawn, such as walls.</summary>
    public BoxCollider[] occluders = new BoxCollider[0];

    /// <summary>Whether renderers moved since the last frame: then all bounds are read again.</summary>
    public bool moving = true;

    readonly List<Renderer> renderers = new List<Renderer>();
    CulletBoxes boxes;
    CulletBox[] bounds;
    bool[] flags;
    Camera eye;

    void OnEnable()
    {
        eye = GetComponent<Camera>();
        boxes = new CulletBoxes();
        renderers.Clear();
        renderers.AddRange(FindObjectsOfType<Renderer>());
        bounds = new CulletBox[renderers.Count];
        flags = new bool[renderers.Count];
        ReadBounds();
        var walls = new CulletOccluder[occluders.Length];
        for (int i = 0; i < walls.Length; i++) walls[i] = Wall(occluders[i]);
        boxes.SetOccluders(walls);
    }

    void OnDisable()
    {
        foreach (Renderer one in renderers) if (one != null) one.forceRenderingOff = false;
        if (boxes != null) boxes.Dispose();
        boxes = null;
    }

    // Before the camera draws, and after everything has moved.
    void LateUpdate()
    {
        // The library was not found.
        if (boxes == null) return;
        if (moving) ReadBounds();
        boxes.Cull(View(), flags);
        for (int i = 0; i < flags.Length; i++) if (renderers[i] != null) renderers[i].forceRenderingOff = !flags[i];
    }

    void ReadBounds()
    {
        for (int i = 0; i < bounds.Length; i++)
        {
            // What was destroyed is an empty box.
            if (renderers[i] == null)
            {
                bounds[i] = new CulletBox(1, 1, 1, 0, 0, 0);
                continue;
            }
            Vector3 min = renderers[i].bounds.min, max = renderers[i].bounds.max;
            bounds[i] = new CulletBox(min.x, min.y, min.z, max.x, max.y, max.z);
        }
        boxes.Set(bounds);
    }

    CulletView View()
    {
        // Both matrices have clip depth -1 to 1 in Unity, whatever draws; the library wants 0 to 1.
        Matrix4x4 clip = eye.projectionMatrix * eye.worldToCameraMatrix;
        var numbers = new CulletMatrix();
        for (int i = 0; i < 16; i++) numbers[i] = clip[i];
        for (int column = 0; column < 4; column++)
            numbers[4 * column + 2] = 0.5 * ((double)clip[4 * column + 2] + clip[4 * column + 3]);
        return CulletView.FromMatrix(numbers, CulletDepth.Standard, eye.pixelWidth, eye.pixelHeight);
    }

    static CulletOccluder Wall(BoxCollider wall)
    {
        Vector3 center = wall.center, half = wall.size * 0.5f;
        CulletOccluder occluder = CulletOccluder.Boxes(new CulletBox(
            center.x - half.x, center.y - half.y, center.z - half.z, center.x + half.x, center.y + half.y,
                center.z + half.z));
        Matrix4x4 at = wall.transform.localToWorldMatrix;
        occluder.Transform = new CulletTransform(
            new CulletLinear(
                new CulletFloat3(at[0], at[1], at[2]), new CulletFloat3(at[4], at[5], at[6]),
                new CulletFloat3(at[8], at[9], at[10])),
            new CulletDouble3(at[12], at[13], at[14]));
        return occluder;
    }
}
