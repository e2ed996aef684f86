// Checks of the tests, and which of them runs: Tests.exe NAME [FILE...]
using System;

namespace Cullet.Tests
{
    static class Check
    {
        internal static int Count;

        internal static void That(bool isSo, string what)
        {
            Count++;
            if (!isSo) throw new Exception("not so: " + what);
        }

        internal static void Equal<T>(T expected, T found, string what) =>
            That(Equals(expected, found), $"{what} is {found}, not {expected}");

        /// <summary>The action is refused with a status and a message that has some words.</summary>
        internal static void Refused(CulletStatus status, string words, Action action)
        {
            try
            {
                action();
            }
            catch (CulletException error)
            {
                Equal(status, error.Status, "the status of: " + error.Message);
                That(error.Message.Contains(words), $"\"{error.Message}\" has \"{words}\"");
                return;
            }
            That(false, $"{status} was thrown ({words})");
        }

        internal static void Throws<E>(string words, Action action) where E : Exception
        {
            try
            {
                action();
            }
            catch (E error)
            {
                That(error.Message.Contains(words), $"\"{error.Message}\" has \"{words}\"");
                return;
            }
            That(false, $"{typeof(E).Name} was thrown ({words})");
        }
    }

    static class Program
    {
        static int Main(string[] words)
        {
            try
            {
                switch (words[0])
                {
                    case "layouts":
                        Layouts.Run(words[1], words[2]);
                        break;
                    case "answers":
                        Answers.Run();
                        break;
                    case "mistakes":
                        Mistakes.Run();
                        break;
                    case "golden":
                        Golden.Run(words[1]);
                        break;
                    case "bakes":
                        Bakes.Bake(words[1]);
                        break;
                    case "sets":
                        Bakes.Sets(words[1]);
                        break;
                    case "unity":
                        UnityFrame.Run();
                        break;
                    case "frames":
                        Frames.Run(words.Length > 1 ? int.Parse(words[1]) : 3);
                        break;
                    default:
                        throw new ArgumentException("no test is called " + words[0]);
                }
            }
            catch (Exception error)
            {
                Console.Error.WriteLine(error);
                return 1;
            }
            Console.WriteLine($"{words[0]}: {Check.Count} checks passed");
            return 0;
        }
    }
}
