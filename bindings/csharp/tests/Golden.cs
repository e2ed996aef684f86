// The answers that every host gives: opens baked files, culls them, and compares ids and funnel, bit for bit.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Text;

namespace Cullet.Tests
{
    /// <summary>As much of a reader of JSON as golden.json needs: objects, arrays, numbers as text.</summary>
    sealed class Json
    {
        readonly string text;
        int at;

        Json(string text)
        {
            this.text = text;
        }

        internal static object Read(string text) => new Json(text).Value();

        char Next()
        {
            while (char.IsWhiteSpace(text[at])) at++;
            return text[at];
        }

        object Value()
        {
            switch (Next())
            {
                case '{':
                    var members = new Dictionary<string, object>();
                    foreach (object name in Items('}'))
                    {
                        Skip(':');
                        members[(string)name] = Value();
                    }
                    return members;
                case '[':
                    var values = new List<object>();
                    foreach (object value in Items(']')) values.Add(value);
                    return values;
                case '"':
                    int end = text.IndexOf('"', at + 1);
                    string word = text.Substring(at + 1, end - at - 1);
                    at = end + 1;
                    return word;
                default:
                    int start = at;
                    while (at < text.Length && ",]} \n\r\t".IndexOf(text[at]) < 0) at++;
                    return text.Substring(start, at - start);
            }
        }

        IEnumerable<object> Items(char end)
        {
            at++;
            while (Next() != end)
            {
                yield return Value();
                if (Next() == ',') at++;
            }
            at++;
        }

        void Skip(char expected)
        {
            if (Next() != expected) throw new FormatException($"golden.json: {expected} expected at byte {at}");
            at++;
        }
    }

    static class Golden
    {
        static List<object> List(object of, string key) => (List<object>)((Dictionary<string, object>)of)[key];

        static string Word(object of, string key) => (string)((Dictionary<string, object>)of)[key];

        static double Number(object word) => double.Parse((string)word, CultureInfo.InvariantCulture);

        internal static void Run(string folder)
        {
            int views = 0;
            object golden = Json.Read(File.ReadAllText(Path.Combine(folder, "golden.json")));
            foreach (object one in List(golden, "scenes"))
            {
                using (CulletScene scene = CulletScene.Open(Path.Combine(folder, Word(one, "file"))))
                {
                    string name = Word(one, "name");
                    Check.Equal(uint.Parse(Word(one, "instances")), scene.Info().InstanceCount, $"instances of {name}");
                    int number = 0;
                    foreach (object view in List(one, "views")) View(scene, view, $"{name}, view {number++}");
                    views += number;
                }
            }
            Check.That(views > 0, "golden.json has views");
            Console.WriteLine($"{views} views compared");
        }

        static void View(CulletScene scene, object one, string name)
        {
            double[] matrix = List(one, "clip_from_world").Select(Number).ToArray();
            List<object> viewport = List(one, "viewport");
            CulletView view = CulletView.FromMatrix(
                matrix, CulletDepth.Reversed, (int)Number(viewport[0]), (int)Number(viewport[1]));
            var preset = (CulletPreset)Enum.Parse(typeof(CulletPreset), Word(one, "preset"), true);
            using (var state = new CulletState())
            {
                state.Cull(scene, view, CulletSettings.Preset(preset));
                var handles = new CulletHandle[scene.Info().InstanceCount + 1];
                int count = state.VisibleHandles(scene, handles);
                string found = string.Join(" ", handles.Take(count).Select(h => h.Index).OrderBy(i => i));
                Check.Equal(string.Join(" ", List(one, "visible")), found, $"{name}: visible");
                var rows = state.Funnel().Select(row =>
                    $"{CulletLibrary.Name(row.Stage)} {CulletLibrary.UnitName(row.Unit)} " +
                    $"{Of(row.Entered)} {Of(row.Left)}");
                var wanted = List(one, "funnel").Select(row =>
                    $"{Word(row, "stage")} {Word(row, "unit")} " +
                    $"{string.Join(" ", List(row, "in"))} {string.Join(" ", List(row, "out"))}");
                Check.Equal(string.Join("\n", wanted), string.Join("\n", rows), $"{name}: funnel");
            }
        }

        static string Of(CulletCounts counts) => $"{counts.Instances} {counts.Clusters} {counts.Triangles}";
    }
}
