// Holds structs, numbers and functions of C# against the header of C: writes a C program that compiles only if sizes,
// offsets and types are the same, and compares names and parameters of functions itself.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Text;
using System.Text.RegularExpressions;

namespace Cullet.Tests
{
    static class Layouts
    {
        const BindingFlags Fields = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic;

        /// <summary>Enumerations that are no types of C, with the prefix of their macros.</summary>
        static readonly Dictionary<Type, string> Macros = new Dictionary<Type, string>
        {
            { typeof(CulletMeshFlags), "CULLET_" },
            { typeof(CulletInstanceFlags), "CULLET_" },
            { typeof(CulletDrawState), "CULLET_DRAW_" },
            { typeof(CulletDepth), "CULLET_DEPTH_" }
        };

        /// <summary>Structs that stand for arrays of C.</summary>
        static readonly Type[] Arrays =
        {
            typeof(CulletFloat3), typeof(CulletDouble3), typeof(CulletLinear), typeof(CulletMatrix),
                typeof(CulletHandlePair), typeof(CulletUInt3)
        };

        static readonly Dictionary<Type, string> Numbers = new Dictionary<Type, string>
        {
            { typeof(uint), "uint32_t" }, { typeof(int), "int32_t" }, { typeof(ulong), "uint64_t" },
            { typeof(byte), "uint8_t" }, { typeof(UIntPtr), "size_t" }, { typeof(float), "float" },
            { typeof(double), "double" }, { typeof(void), "void" }
        };

        internal static void Run(string header, string program)
        {
            string text = Regex.Replace(File.ReadAllText(header), @"/\*.*?\*/", "", RegexOptions.Singleline);
            var here = typeof(CulletNative).Assembly.GetTypes().Where(t => t.Namespace == "Cullet" && t.IsValueType);
            // Those that begin with a capital and are no field for field copy of C's.
            Type[] ours = { typeof(CulletShadow), typeof(CulletOccluder), typeof(CulletBoxLayout) };
            Type[] all = here.Where(t => !ours.Contains(t) && !Arrays.Contains(t) && !t.IsGenericType && IsNamed(t))
                .ToArray();
            var names = new HashSet<string>(all.Where(t => !Macros.ContainsKey(t)).Select(Name));
            var there = Regex.Matches(text, @"\} (cullet_\w+);").Cast<Match>().Select(m => m.Groups[1].Value).ToArray();
            Check.That(there.Length > 40, "the header has types");
            foreach (string name in there) Check.That(names.Contains(name), $"C# has {name}");
            foreach (string name in names) Check.That(there.Contains(name), $"the header has {name}");
            var c = new StringBuilder("#include <cullet.h>\n#define SAME(a, b) _Static_assert((a) == (b), #a)\n");
            foreach (Type type in all.OrderBy(Name))
                if (type.IsEnum) Enumeration(c, type, text);
                else Struct(c, type, text);
            File.WriteAllText(program, c.Append("int main(void) { return 0; }\n").ToString());
            Functions(text);
        }

        static bool IsNamed(Type type) => type.Name.StartsWith("Cullet") || type.Name.StartsWith("cullet_");

        static string Snake(string name) =>
            Regex.Replace(name, "(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_").ToLowerInvariant();

        static string Name(Type type) => Snake(type.Name);

        static void Enumeration(StringBuilder c, Type type, string text)
        {
            string prefix, value = @" = \d+,?\s";
            if (!Macros.TryGetValue(type, out prefix)) prefix = Name(type).ToUpperInvariant() + "_";
            string[] names = Enum.GetNames(type).Where(n => !(n == "None" && Macros.ContainsKey(type))).ToArray();
            foreach (string name in names)
            {
                ulong number = Convert.ToUInt64(Enum.Parse(type, name));
                c.AppendLine($"SAME({prefix}{Snake(name).ToUpperInvariant()}, {number});");
            }
            if (!Macros.ContainsKey(type))
                Check.Equal(Regex.Matches(text, prefix + "[A-Z0-9_]+" + value).Count, names.Length,
                    $"numbers of {type.Name}");
            Check.Count += names.Length;
        }

        static void Struct(StringBuilder c, Type type, string text)
        {
            string name = Name(type);
            FieldInfo[] fields = type.GetFields(Fields);
            string body = Regex.Match(text, @"typedef struct \{([^}]*)\} " + name + ";").Groups[1].Value;
            Check.Equal(body.Count(one => one == ';'), fields.Length, $"fields of {name}");
            c.AppendLine($"SAME(sizeof({name}), {Marshal.SizeOf(type)});");
            foreach (FieldInfo field in fields)
            {
                string at = Snake(field.Name), of = $"(({name} *)0)->{at}";
                c.AppendLine($"SAME(offsetof({name}, {at}), {Marshal.OffsetOf(type, field.Name)});");
                Type inner = field.FieldType;
                bool isArray = Arrays.Contains(inner);
                if (!inner.IsPointer && inner != typeof(IntPtr))
                {
                    Type plain = inner.IsEnum ? Enum.GetUnderlyingType(inner) : inner;
                    c.AppendLine($"SAME(sizeof({of}), {Marshal.SizeOf(plain)});");
                }
                // The C compiler tells float from int, and signed from unsigned.
                // The type of a fixed buffer has a name that is no name.
                while (Arrays.Contains(inner) || inner.Name.StartsWith("<"))
                    inner = inner.GetFields(Fields)[0].FieldType;
                if (inner.IsEnum) inner = Enum.GetUnderlyingType(inner);
                if (inner == typeof(IntPtr)) continue;
                string of1 = isArray ? of + "[0]" : of, words = Spelled(inner);
                string constant = inner.IsPointer ? $", const {words}: 1" : "";
                c.AppendLine($"SAME(_Generic({of1}, {words}: 1{constant}, default: 0), 1);");
            }
            Check.Count += 3 * fields.Length;
        }

        /// <summary>A type as C spells it.</summary>
        static string Spelled(Type type)
        {
            if (type.IsPointer) return Spelled(type.GetElementType()) + " *";
            string number;
            if (Numbers.TryGetValue(type, out number)) return number;
            return Name(type);
        }

        static void Functions(string text)
        {
            var imported = typeof(CulletNative)
                .GetMethods(BindingFlags.Public | BindingFlags.Static | BindingFlags.DeclaredOnly);
            const string function = @"^(?:const )?(\w+ \*?)(cullet_\w+)\(([^;{]*)\);";
            var found = Regex.Matches(text, function, RegexOptions.Multiline).Cast<Match>()
                .ToDictionary(m => m.Groups[2].Value);
            Check.That(found.Count > 60, "the header has functions");
            Check.Equal(found.Count, imported.Length, "functions of C#");
            foreach (MethodInfo method in imported)
            {
                Check.That(found.ContainsKey(method.Name), $"the header has {method.Name}");
                Match there = found[method.Name];
                string[] parameters = Regex.Split(there.Groups[3].Value.Trim(), @",\s*");
                string wanted = string.Join(", ", parameters.Where(p => p != "void").Select(Normal));
                string has = string.Join(", ",
                    method.GetParameters().Select(p => Normal(Spelled(p.ParameterType) + " " + p.Name)));
                Check.Equal(wanted, has, $"parameters of {method.Name}");
                string returned = Normal(there.Groups[1].Value + " x"),
                    ours = Normal(Spelled(method.ReturnType) + " x");
                Check.Equal(returned, ours, $"what {method.Name} returns");
            }
        }

        /// <summary>A parameter without const; a text is bytes.</summary>
        static string Normal(string parameter) =>
            Regex.Replace(parameter.Replace("const ", "").Replace("char ", "uint8_t ").Replace("*", " * "), @"\s+",
                " ").Trim();
    }
}
