/* The answers that every host gives: opens baked files, culls them, and compares ids and funnel, bit for bit.
 * golden FOLDER: FOLDER/golden.json has the views and the answers. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cullet.h>

/* As much of a JSON reader as this file needs: it goes through the text once, and takes keys in their order. */
static char *text;

static void fail(const char *what) {
    fprintf(stderr, "golden.json: %s expected at: %.60s\n", what, text);
    exit(1);
}
static void blanks(void) { text += strspn(text, " \n\r\t"); }
static int next(char c) {
    blanks();
    if (*text != c) return 0;
    text++;
    return 1;
}
static void expect(char c) {
    char what[2] = {c, 0};
    if (!next(c)) fail(what);
}
static void string(char *to, size_t room) {
    expect('"');
    size_t length = strcspn(text, "\"");
    if (length >= room) fail("a shorter string");
    memcpy(to, text, length);
    to[length] = 0;
    text += length + 1;
}
static void key(const char *name) {
    char found[64];
    next(',');
    string(found, sizeof found);
    if (strcmp(found, name) != 0) fail(name);
    expect(':');
}
static double number(void) {
    char *end;
    blanks();
    double value = strtod(text, &end);
    if (end == text) fail("a number");
    text = end;
    return value;
}
static uint64_t whole(void) {
    char *end;
    blanks();
    uint64_t value = strtoull(text, &end, 10);
    if (end == text) fail("a whole number");
    text = end;
    return value;
}
/* Passes over a value. */
static void skip(void) {
    int depth = 0;
    do {
        blanks();
        if (*text == 0) fail("an end");
        if (*text == '"') {
            text += 1;
            text += strcspn(text, "\"");
        } else if (*text == '{' || *text == '[') {
            depth++;
        } else if (*text == '}' || *text == ']') {
            if (depth == 0) return;
            depth--;
        } else if (*text == ',' && depth == 0) {
            return;
        }
        text++;
    } while (1);
}

static void check(cullet_status status) {
    if (status == CULLET_STATUS_OK) return;
    fprintf(stderr, "%s\n", cullet_last_error());
    exit(1);
}

static int by_size(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static char *contents(const char *path) {
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fprintf(stderr, "%s cannot be opened\n", path);
        exit(1);
    }
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    char *all = malloc((size_t)size + 1);
    rewind(file);
    if (size < 0 || all == NULL || fread(all, 1, (size_t)size, file) != (size_t)size) {
        fprintf(stderr, "%s cannot be read\n", path);
        exit(1);
    }
    all[size] = 0;
    fclose(file);
    return all;
}

static int views = 0, wrong = 0;

static void differs(const char *scene, int view, const char *what) {
    fprintf(stderr, "%s, view %d: %s differs\n", scene, view, what);
    wrong++;
}

static void one_view(const char *name, int at, cullet_scene scene, uint32_t instances) {
    double matrix[16];
    char preset[16];
    cullet_view view;
    cullet_state state;
    cullet_settings settings;
    size_t count, row = 0, visible = 0;
    cullet_funnel_row rows[32];
    cullet_handle *handles = malloc(sizeof *handles * (instances + 1));
    uint32_t *indices = malloc(sizeof *indices * (instances + 1));
    expect('{');
    key("camera"), skip();
    key("clip_from_view"), skip();
    key("clip_from_world"), expect('[');
    for (int i = 0; i < 16; i++) next(','), matrix[i] = number();
    expect(']');
    key("viewport"), expect('[');
    uint32_t width = (uint32_t)whole();
    expect(',');
    uint32_t height = (uint32_t)whole();
    expect(']');
    key("preset"), string(preset, sizeof preset);
    check(cullet_view_from_matrix(matrix, CULLET_DEPTH_REVERSED, width, height, &view));
    check(cullet_settings_preset(strcmp(preset, "exact") == 0   ? CULLET_PRESET_EXACT
                                 : strcmp(preset, "fast") == 0 ? CULLET_PRESET_FAST
                                                               : CULLET_PRESET_BALANCED,
                                 &settings));
    check(cullet_state_create(&state));
    check(cullet_cull(scene, &view, &settings, state));
    check(cullet_visible_handles(state, scene, handles, instances, &count));
    for (size_t i = 0; i < count; i++) indices[i] = handles[i].index;
    qsort(indices, count, sizeof *indices, by_size);
    key("visible"), expect('[');
    int same = 1;
    while (!next(']')) {
        next(',');
        uint64_t index = whole();
        same &= visible < count && indices[visible] == index;
        visible++;
    }
    if (!same || visible != count) differs(name, at, "visible");
    check(cullet_visible_funnel(state, rows, 32, &count));
    key("funnel"), expect('[');
    while (!next(']')) {
        char stage[32], unit[32];
        uint64_t of[6];
        next(','), expect('{');
        key("stage"), string(stage, sizeof stage);
        key("unit"), string(unit, sizeof unit);
        for (int side = 0; side < 2; side++) {
            key(side == 0 ? "in" : "out"), expect('[');
            for (int i = 0; i < 3; i++) next(','), of[side * 3 + i] = whole();
            expect(']');
        }
        expect('}');
        const uint64_t counts[6] = {rows[row].entered.instances, rows[row].entered.clusters,
                                    rows[row].entered.triangles, rows[row].left.instances,
                                    rows[row].left.clusters,     rows[row].left.triangles};
        if (row >= count || strcmp(stage, cullet_stage_name(rows[row].stage)) != 0 ||
            strcmp(unit, cullet_unit_name(rows[row].unit)) != 0 || memcmp(of, counts, sizeof of) != 0)
            differs(name, at, "a row of the funnel");
        row++;
    }
    if (row != count) differs(name, at, "the number of rows");
    expect('}');
    check(cullet_state_destroy(state));
    free(handles);
    free(indices);
    views++;
}

int main(int argc, char **argv) {
    const char *folder = argc > 1 ? argv[1] : getenv("CULLET_GOLDEN"), *required = getenv("CULLET_REQUIRE_DATA");
    char path[4096], name[64], file[64];
    if (folder == NULL) {
        printf("skipped: CULLET_GOLDEN names no folder\n");
        return required != NULL && strcmp(required, "1") == 0;
    }
    snprintf(path, sizeof path, "%s/golden.json", folder);
    char *all = text = contents(path);
    int scenes = 0;
    expect('{'), key("scenes"), expect('[');
    while (!next(']')) {
        cullet_scene scene;
        cullet_scene_info info;
        next(','), expect('{');
        key("name"), string(name, sizeof name);
        key("file"), string(file, sizeof file);
        key("instances");
        uint64_t instances = whole();
        snprintf(path, sizeof path, "%s/%s", folder, file);
        check(cullet_open(path, &scene));
        check(cullet_scene_get_info(scene, &info));
        if (info.instance_count != instances) differs(name, 0, "the number of instances");
        key("views"), expect('[');
        int view = 0;
        while (!next(']')) next(','), one_view(name, view++, scene, info.instance_count);
        expect('}');
        check(cullet_scene_destroy(scene));
        scenes++;
    }
    expect('}');
    free(all);
    printf("%d views of %d scenes compared, %d differences\n", views, scenes, wrong);
    return wrong != 0 || views == 0;
}
