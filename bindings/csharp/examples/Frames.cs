// A scene made by hand, culled frame after frame into arrays that are used again: nothing is allocated in the loop.
using System;
using Cullet;

static class Program
{
    const int Side = 32;

    static void Main()
    {
        float[] corners = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1 };
        uint[] faces =
        {
            0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5
        };
        using (var scene = new CulletScene())
        using (var state = new CulletState())
        {
            uint box = scene.AddMesh(corners, faces, CulletMeshFlags.OneSided);
            for (int i = 0; i < Side * Side; i++)
            {
                var at = new CulletDouble3(3 * (i % Side), 0, 3 * (i / Side));
                scene.Add(new CulletInstance(box, new CulletTransform(CulletLinear.Scale(1, 1 + i % 7, 1), at),
                    (ulong)i));
            }
            scene.Commit();

            var draws = new CulletDraws();
            for (int frame = 0; frame < 8; frame++)
            {
                var view = CulletView.LookAt(
                    new CulletDouble3(-2, 2, 3 * frame), new CulletDouble3(40, 1, 40), 0.9, 0.1, 1280, 720);
                state.Cull(scene, view);
                state.Draws(scene, draws);
                int instances = draws.Instances.Length, commands = draws.Commands.Length;
                Console.WriteLine($"frame {frame}: {instances} instances in {commands} draws");
            }
        }
    }
}
