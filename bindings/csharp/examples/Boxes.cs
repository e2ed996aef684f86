using System;
using Cullet;

struct Item
{
    public CulletFloat3 Center, Half;

    public Item(float x, float y, float z, float halfX, float halfY, float halfZ)
    {
        Center = new CulletFloat3(x, y, z);
        Half = new CulletFloat3(halfX, halfY, halfZ);
    }
}

static class Program
{
    static void Main()
    {
        string[] names = { "tree", "house", "rock behind the wall", "car behind the eye", "tower behind the wall" };
        Item[] items =
        {
            new Item(-2, 2, -20, 1, 2, 1), new Item(6, 3, -30, 4, 3, 4), new Item(0, 1, -50, 2, 1, 2),
            new Item(0, 1, 10, 2, 1, 1), new Item(9, 20, -60, 3, 20, 3)
        };
        using (var boxes = new CulletBoxes())
        {
            boxes.Set(items, CulletBoxLayout.Of<Item>("Center", "Half", CulletBoxForm.CenterHalf));
            boxes.SetOccluders(CulletOccluder.Boxes(new CulletBox(-40, 0, -41, 40, 9, -40)));

            Span<bool> flags = new bool[items.Length]; // once; each frame:
            var view = CulletView.LookAt(
                new CulletDouble3(0, 2, 0), new CulletDouble3(0, 2, -10), 0.9, 0.1, 1280, 720);
            int visible = boxes.Cull(view, flags);
            for (int i = 0; i < items.Length; i++)
                if (flags[i]) Console.WriteLine($"draw the {names[i]}");
            Console.WriteLine($"{visible} of {items.Length} boxes may be visible");
        }
    }
}
