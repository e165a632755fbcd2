#include "resource_folder.h"

#include <stdlib.h>
#include <string.h>

#include "memory.h"

static int digit(char letter)
{
    if (letter >= '0' && letter <= '9')
        return letter - '0';
    letter = (char)(letter | 0x20);
    return letter >= 'a' && letter <= 'f' ? letter - 'a' + 10 : -1;
}

static void decode(char *text)
{
    char *to = text;

    for (const char *from = text; *from != '\0'; to++) {
        int high = *from == '%' ? digit(from[1]) : -1, low = high < 0 ? -1 : digit(from[2]);
        *to = low < 0 ? *from : (char)(16 * high + low);
        from += low < 0 ? 1 : 3;
    }
    *to = '\0';
}

char *folder_of_uri(const char *uri)
{
    static const char scheme[] = "file:";
    char *folder;
    size_t length;

    if (strncmp(uri, scheme, sizeof scheme - 1) != 0)
        return NULL;
    uri += sizeof scheme - 1;
    if (uri[0] == '/' && uri[1] == '/') {
        if (strncmp(uri + 2, "localhost/", sizeof "localhost/" - 1) == 0)
            uri += sizeof "localhost" - 1;
        if (uri[2] == '/')
            uri += 2; /* without an authority; with one it is a share of Windows */
    }
#ifdef _WIN32
    if (uri[0] == '/' && uri[1] != '\0' && (uri[2] == ':' || uri[2] == '|'))
        uri++;
#endif
    folder = copy_text(uri);
    if (folder == NULL)
        return NULL;
    decode(folder);
    length = strlen(folder);
    while (length > 1 && folder[length - 1] == '/')
        folder[--length] = '\0';
    return folder;
}

static int plain(char letter)
{
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') || (letter >= '0' && letter <= '9')
           || (letter != '\0' && strchr("-._~/:", letter) != NULL);
}

char *uri_of_folder(const char *folder)
{
    static const char digits[] = "0123456789ABCDEF";
    char *uri = malloc(3 * strlen(folder) + sizeof "file:///"), *to = uri;

    if (uri == NULL)
        return NULL;
    memcpy(to, "file://", sizeof "file://" - 1);
    to += sizeof "file://" - 1;
#ifdef _WIN32
    if (folder[0] != '/' && folder[0] != '\\')
        *to++ = '/'; /* before the letter of a drive */
    else if (folder[1] == folder[0])
        folder += 2; /* the authority of a share */
#endif
    for (; *folder != '\0'; folder++) {
#ifdef _WIN32
        const char letter = *folder == '\\' ? '/' : *folder;
#else
        const char letter = *folder;
#endif
        if (plain(letter)) {
            *to++ = letter;
            continue;
        }
        *to++ = '%';
        *to++ = digits[(unsigned char)letter >> 4];
        *to++ = digits[(unsigned char)letter & 15];
    }
    *to = '\0';
    return uri;
}

static int separates(char letter)
{
#ifdef _WIN32
    return letter == '/' || letter == '\\';
#else
    return letter == '/';
#endif
}

char *folder_of_path(const char *path)
{
    char *folder = copy_text(path);
    size_t length = folder == NULL ? 0 : strlen(folder);

    while (length > 1 && separates(folder[length - 1]))
        folder[--length] = '\0';
    return folder;
}
