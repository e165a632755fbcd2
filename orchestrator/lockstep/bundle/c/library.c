#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L
#endif
#include "library.h"

#include <stdlib.h>

#ifdef _WIN32

const char *const library_folders[LIBRARY_PLACES] = {"win64", "x86_64-windows"};
const char library_suffix[] = ".dll";

/* windows.h would bring hundreds of names more */
__declspec(dllimport) void *__stdcall LoadLibraryExW(const wchar_t *path, void *file, unsigned long flags);
__declspec(dllimport) void *__stdcall GetProcAddress(void *library, const char *name);
__declspec(dllimport) int __stdcall FreeLibrary(void *library);
__declspec(dllimport) unsigned long __stdcall GetLastError(void);
__declspec(dllimport) int __stdcall MultiByteToWideChar(unsigned int page, unsigned long flags, const char *text,
                                                        int length, wchar_t *wide, int size);

enum { UTF8 = 65001, BESIDE_THE_LIBRARY = 8 }; /* look for further libraries in its folder */

static wchar_t *wide_path(const char *path)
{
    int size = MultiByteToWideChar(UTF8, 0, path, -1, NULL, 0);
    wchar_t *wide = size > 0 ? malloc((size_t)size * sizeof *wide) : NULL;

    if (wide != NULL)
        MultiByteToWideChar(UTF8, 0, path, -1, wide, size);
    return wide;
}

void *library_open(const char *path)
{
    wchar_t *wide = wide_path(path);
    void *library = wide == NULL ? NULL : LoadLibraryExW(wide, NULL, BESIDE_THE_LIBRARY);

    free(wide);
    return library;
}

void *library_symbol(void *library, const char *name)
{
    return GetProcAddress(library, name);
}

void library_close(void *library)
{
    FreeLibrary(library);
}

void library_error(char *text, size_t size)
{
    snprintf(text, size, "error %lu of Windows", GetLastError());
}

FILE *open_to_read(const char *path)
{
    wchar_t *wide = wide_path(path);
    FILE *file = wide == NULL ? NULL : _wfopen(wide, L"rb");

    free(wide);
    return file;
}

#else

#include <dlfcn.h>

#if defined(__APPLE__)
const char *const library_folders[LIBRARY_PLACES] = {"darwin64", "darwin64"};
const char library_suffix[] = ".dylib";
#elif defined(__aarch64__)
const char *const library_folders[LIBRARY_PLACES] = {"aarch64-linux", "linux64"};
const char library_suffix[] = ".so";
#else
const char *const library_folders[LIBRARY_PLACES] = {"linux64", "x86_64-linux"};
const char library_suffix[] = ".so";
#endif

void *library_open(const char *path)
{
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

void *library_symbol(void *library, const char *name)
{
    return dlsym(library, name);
}

void library_close(void *library)
{
    dlclose(library);
}

void library_error(char *text, size_t size)
{
    const char *reason = dlerror();

    snprintf(text, size, "%s", reason == NULL ? "no reason is given" : reason);
}

FILE *open_to_read(const char *path)
{
    return fopen(path, "rb");
}

#endif
